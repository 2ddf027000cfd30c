% Reads the MAT file of a run and compares it with its CSV file.
%
%     octave-cli readers.m surface.mat surface.csv

files = argv();
loaded = load(files{1});
file = fopen(files{2});
names = strsplit(fgetl(file), ",");
fclose(file);
table = dlmread(files{2}, ",", 1, 0);

axes = loaded.axes;
assert(iscellstr(axes) && rows(axes) == 1)
assert(axes, {"pad_mass", "rotating_speed_rad_s", "std_preload", "preload", "static_friction"})
lengths = cellfun(@(name) numel(loaded.(name)), axes);
assert(lengths, [2, 2, 1, 3, 4])
assert(table(:, 1)', 0:prod(lengths) - 1)
for column = 1:numel(names)
    name = strrep(names{column}, ".", "_");
    values = loaded.(name);
    assert(isa(values, "double"), "%s is no double", name)
    % Cells are numbered so that the last axis varies fastest; Octave varies the first one fastest.
    for cell = 0:prod(lengths) - 1
        places = num2cell(fliplr(mod(floor(cell ./ [1, cumprod(fliplr(lengths)(1:end - 1))]), fliplr(lengths))) + 1);
        axis = find(strcmp(axes, name));
        if isempty(axis)
            found = values(places{:});
        else
            found = values(places{axis});
        end
        assert(isequaln(found, table(cell + 1, column)), "%s in cell %d", name, cell)
    end
end
% As the documents index it.
wanted = table(24 + 8 + (1:4), strcmp(names, "p_unstable"));
assert(squeeze(loaded.p_unstable(2, 1, 1, 3, :)), wanted)
disp("Octave agrees with the CSV file")
