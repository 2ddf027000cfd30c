# What a user types: `make run`, `make test` and `make docs`. Everything else is for developers.

CARGO  ?= cargo
PYTHON ?= python3
STICKSLIP = target/release/stickslip

# What `make check` does.
CHECKS = check-format check-dependencies check-lints check-documentation check-packages check-stages

.PHONY: run test quick test-optimisation test-faults test-slurm test-parallel program check $(CHECKS) packages docs docs-pictures wheel dist-wheel dist local test-python test-dist test-release test-reproducible test-aarch64 install uninstall bench bench-peers validity coverage clean
.DEFAULT_GOAL := run
# Targets share folders, and cargo uses all processors anyway.
.NOTPARALLEL:

# Build, and run the main job: Figure 14a.
run:
	$(CARGO) build --locked --release
	$(STICKSLIP) submit jobs/fig14a.toml

# One more test runs at a time than there are processors, since many wait.
TEST = RUST_TEST_THREADS=$${RUST_TEST_THREADS:-$$(($$(nproc || getconf _NPROCESSORS_ONLN) + 1))} $(CARGO) test --locked
TESTS = $(TEST) --release --workspace --no-fail-fast

# The tests, built as the program is, but for its own unit tests: to optimise them takes longer than to run them. Those of
# the Python readers need Python with venv, those of the report a Chromium as well; without them they are left out, with a
# word about it.
test: target/readers/ready
	if [ -x target/readers/bin/python ]; then \
	    export STICKSLIP_PYTHON="$(CURDIR)/target/readers/bin/python"; \
	else \
	    echo "note: no Python environment, the tests of pandas, polars and DuckDB are left out" >&2; \
	fi; \
	browser="$$(command -v chromium || command -v chromium-browser || command -v google-chrome)"; \
	if [ -n "$$browser" ]; then \
	    export STICKSLIP_BROWSER="$$browser"; \
	else \
	    echo "note: no Chromium, the test of the report in a browser is left out" >&2; \
	fi; \
	failed=; \
	$(TESTS) --lib --test '*' || failed=1; \
	$(TESTS) --bins --config profile.release.package.stickslip.opt-level=0 || failed=1; \
	$(TESTS) --doc || failed=1; \
	[ -z "$$failed" ]

# For while you write, an answer within a minute after a changed line: the unit tests and those of the command line, but for
# the slow ones, with little optimisation and with checks for overflow. The first time builds the dependencies.
quick:
	$(TEST) --profile quick --workspace --lib --bins --test people

# What happens to runs that are killed, starved, damaged or disturbed, see docs/faults.md. `make test-faults FAULTS=all` makes
# the full number of tries, which takes hours.
test-faults:
	$(CARGO) build --locked --release
	$(PYTHON) -B tests/faults $(STICKSLIP) $(if $(filter all,$(FAULTS)),--all)

# Whether the program gives the same bytes when it is optimised less, with checks for overflow. Builds it once more: for releases.
test-optimisation:
	$(CARGO) build --locked --profile quick
	STICKSLIP_OTHER_PROGRAM="$(CURDIR)/target/quick/stickslip" \
	    $(CARGO) test --locked --release -p stickslip --test runs -- --ignored optimisation

# Python compiles what is imported, which is a part of what is installed.
PIP_INSTALL = -m pip install --quiet --disable-pip-version-check --no-compile

target/readers/ready: tests/requirements.txt
	mkdir -p target/readers
	if $(PYTHON) -m venv target/readers && target/readers/bin/python $(PIP_INSTALL) -r tests/requirements.txt; then \
	    touch $@; \
	else \
	    rm -rf target/readers; test -z "$$CI"; \
	fi

# What other targets need of Python, each in an environment of its own: UQpy needs older versions of NumPy and others than the
# rest of its peers.
target/packaging/ready: packaging/requirements.txt
target/dist-tests/ready: tests/dist/requirements.txt
target/site/ready: docs/requirements.txt
target/peers/ready: benches/peers-requirements.txt
target/peers-uqpy/ready: benches/peers-uqpy-requirements.txt
target/packaging/ready target/dist-tests/ready target/site/ready target/peers/ready target/peers-uqpy/ready: target/%/ready:
	$(PYTHON) -m venv target/$*
	target/$*/bin/python $(PIP_INSTALL) -r $<
	touch $@

# The engines that run the shards of a job on many machines, each on this one: a cluster of Slurm, and GNU parallel over
# ssh. They need root and the packages of Debian, and are left out elsewhere, with a word about it.
PROGRAM = $(STICKSLIP)

test-slurm test-parallel: test-%: program
	tests/engines/$*.sh $(PROGRAM)

program:
	if [ "$(PROGRAM)" = "$(STICKSLIP)" ]; then $(CARGO) build --locked --release; fi

# The Python package for this machine and those like it, in target/local: a wheel with the program that cargo builds here, and
# that was tested. Where the program is built, this takes less than a minute.
LOCAL = target/local
SOURCE_DATE_EPOCH ?= $(or $(shell git log -1 --format=%ct 2>/dev/null),315532800)
PACKAGED = PATH="$(CURDIR)/target/packaging/bin:$$PATH" SOURCE_DATE_EPOCH=$(SOURCE_DATE_EPOCH)

wheel: program target/packaging/ready
	rm -rf $(LOCAL)
	$(PACKAGED) maturin build --quiet --release --locked --strip false --compatibility linux --out $(LOCAL)
	$(PACKAGED) python -B packaging/wheel.py $(HOST_TARGET) $(LOCAL)/stickslip-*.whl

# The same with the archive. Not to be passed on: their list of parts and their README are those of a release.
local: wheel
	$(PACKAGED) python -B packaging/archive.py $(HOST_TARGET) $(LOCAL)/stickslip-*.whl - $(LOCAL)

# The program for those who have no toolchain, in target/dist: as a wheel, which is the Python package, and as an archive with
# manual pages, completions, licences and a list of parts. Both hold the same program. It runs on every Linux with glibc 2.17
# or newer (manylinux2014), to which Zig links, so that it is built once more. The same commit gives the same bytes. `make dist
# DIST_TARGET=aarch64-unknown-linux-gnu` builds for another processor.
DIST = target/dist
HOST_TARGET = $(shell uname -m)-unknown-linux-gnu
DIST_TARGET = $(HOST_TARGET)
DIST_WHEEL = $(DIST)/stickslip-*_$(firstword $(subst -, ,$(DIST_TARGET))).whl

dist-wheel: target/packaging/ready
	rm -f $(DIST_WHEEL)
	$(PACKAGED) packaging/build.sh $(DIST_TARGET) $(DIST)

# Where the program does not run on this machine, the one that does writes the manual.
dist: dist-wheel $(if $(filter $(HOST_TARGET),$(DIST_TARGET)),,program)
	rm -f $(DIST)/stickslip-$(DIST_TARGET)-v*
	$(PACKAGED) python -B packaging/archive.py $(DIST_TARGET) $(DIST_WHEEL) \
		$(if $(filter $(HOST_TARGET),$(DIST_TARGET)),-,$(PROGRAM)) $(DIST)

test-python: local
	rm -rf target/python-tests
	$(PYTHON) -m venv target/python-tests
	target/python-tests/bin/python $(PIP_INSTALL) -r tests/python/requirements.txt
	target/python-tests/bin/python $(PIP_INSTALL) \
		"stickslip[pandas,polars,xarray,notebook] @ file://$(CURDIR)/$$(echo $(LOCAL)/stickslip-*.whl)"
	env -u STICKSLIP_PROGRAM target/python-tests/bin/python -m pytest tests/python
	target/python-tests/bin/python -m mypy --strict python/stickslip

# What is in the wheel and the archive, and what `make install` does: of the local ones, and of those of a release, where
# the program must run on older systems and may not say where it was built.
test-dist: local
test-release: dist
test-dist: TESTED = $(LOCAL)
test-release: TESTED = $(DIST)
test-dist test-release: target/dist-tests/ready
	$(PACKAGED) target/dist-tests/bin/python -B -m pytest -p no:cacheprovider tests/dist --packages $(TESTED) \
		$(if $(filter test-dist,$@),-m "not release")

# Whether another copy of the commit, elsewhere and in other circumstances, gives the same bytes. It builds the program
# again, which takes minutes.
test-reproducible: dist
	tests/dist/reproducible.sh $(DIST) $(DIST_TARGET)

# The program for aarch64, run by an emulator: it gives what the program of this machine gives. Installs the emulator where
# it is missing, for which it needs root and the packages of Debian.
test-aarch64: dist-wheel
	tests/dist/install-emulator.sh
	$(MAKE) dist-wheel DIST_TARGET=aarch64-unknown-linux-gnu
	$(PACKAGED) tests/dist/aarch64.sh $(DIST)

# Installs the program, its manual and completions for the shells. `make install PREFIX=/usr DESTDIR=stage` puts them below
# stage/usr, for packages.
PREFIX = /usr/local
DESTDIR =
INSTALLED = bin/stickslip share/bash-completion/completions/stickslip share/zsh/site-functions/_stickslip \
	share/fish/vendor_completions.d/stickslip.fish share/stickslip

install: program
	rm -rf target/install
	packaging/share.sh "$(PROGRAM)" target/install
	install -d "$(DESTDIR)$(PREFIX)/bin"
	install -m 755 "$(PROGRAM)" "$(DESTDIR)$(PREFIX)/bin/stickslip"
	find target/install -type f | while read -r file; do \
	    place="$(DESTDIR)$(PREFIX)/share/$${file#target/install/}"; \
	    install -d "$${place%/*}" && install -m 644 "$$file" "$$place" || exit 1; \
	done

uninstall:
	cd "$(DESTDIR)$(PREFIX)" && rm -rf $(INSTALLED) && rm -f share/man/man1/stickslip.1 share/man/man1/stickslip-*.1

# Formatting, known vulnerabilities of dependencies, lints, documentation, and whether the crates can be packaged; all warnings
# are errors. Building what was packaged takes minutes: `make packages` does. `make test` has the licences of dependencies and
# the order of imports.
check: $(CHECKS)

check-format:
	$(CARGO) fmt --all --check

check-dependencies:
	if $(CARGO) deny --version >/dev/null 2>&1; then \
	    $(CARGO) deny --locked check; \
	else \
	    echo "note: no cargo-deny, known vulnerabilities of dependencies are not looked up" >&2; \
	fi

# In the profile of the tests, so that the macros and build scripts of dependencies are built once.
check-lints:
	$(CARGO) clippy --locked --release --workspace --all-targets -- -D warnings

check-documentation:
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --locked --release --workspace --no-deps

check-packages:
	$(CARGO) package --locked --quiet --workspace --allow-dirty --no-verify

# What .ci/run reads from the output of tests.
check-stages:
	$(PYTHON) -B .ci/test_stages.py

# The crates as others get them, each built from its package alone.
packages:
	$(CARGO) package --locked --workspace --allow-dirty

# The documentation as a site in target/docs, to be opened in a browser: README.md, ARCHITECTURE.md and docs/. Pages link as in
# a view of the repository.
docs: target/site/ready
	rm -rf target/docs
	target/site/bin/python -B -m sphinx -W --keep-going -q -E -d target/site/doctrees -c docs . target/docs
	cp target/docs/README.html target/docs/index.html

# The figures of docs/reproduction.md. Figure 14b, which takes minutes, is left out.
FIGURES = fig4 fig5 fig6 fig7 fig8 fig9 fig10 fig11 fig12 fig13 fig14a fig14c fig14d fig15a fig15b

# The pictures of the documents that the program draws.
docs-pictures:
	$(CARGO) build --locked --release
	rm -rf target/pictures
	$(call picture,fig14a)
	$(call picture,parking)
	$(call picture,parking-map)
	$(STICKSLIP) reproduce $(FIGURES) --out target/pictures >/dev/null
	mkdir -p docs/figures
	sed -n '/^# bedded.toml/,/^```/p' docs/how-to/see-inputs-and-samples.md | sed '$$d' > target/pictures/bedded.toml
	$(STICKSLIP) plot target/pictures/bedded.toml --cell 7 --out docs/figures/inputs.svg
	$(STICKSLIP) plot jobs/hulten.toml --of modes --cell 16 --out docs/figures/modes.svg
	$(STICKSLIP) plot jobs/hulten.toml --of squeal-frequencies --cell 16 --out docs/figures/squeal-frequencies.svg
	$(STICKSLIP) reduce jobs/own-brake.toml --vectors 120 --out target/pictures/own-brake-120.toml >/dev/null
	$(STICKSLIP) plot target/pictures/own-brake-120.toml --of modes --along friction --cell 3 --out docs/figures/own-brake-modes.svg
	$(STICKSLIP) plot target/pictures/own-brake-120.toml --of squeal-frequencies --cell 0 --out docs/figures/own-brake-frequencies.svg
	for name in $(FIGURES); do cp "target/pictures/$$name/$$name.svg" docs/figures/ || exit 1; done

# Runs a job in jobs/ and draws its surface in docs/.
picture = $(STICKSLIP) submit jobs/$(1).toml --out target/pictures/$(1) >/dev/null \
	&& $(STICKSLIP) plot target/pictures/$(1) --out docs/$(1).svg

# One line for each figure: name, value, unit.
bench:
	$(CARGO) bench --locked -p stickslip --bench figures --bench methods --bench inputs
	$(CARGO) build --locked --release
	$(PYTHON) -B benches/signals.py $(STICKSLIP)

# The tables of the range of validity (docs of `stickslip_core::models::pad_on_disc::criterion::validity`): verdicts against references, case by case.
validity:
	$(CARGO) bench --locked -p stickslip-core --bench validity

# The table of coverage: how often intervals contain the true value, by simulation.
coverage:
	$(CARGO) bench --locked -p stickslip-sampler --bench coverage --bench rare_adversaries --bench fit_coverage

# The same jobs by NumPy, OpenTURNS, UQpy, numba, SciPy and diffrax beside it.
bench-peers: target/peers/ready target/peers-uqpy/ready
	$(CARGO) build --locked --release
	failed=; for bench in peers peers_methods peers_matrices peers_rare_events peers_time_domain peers_starts; do \
		more=; [ $$bench = peers_rare_events ] && more=target/peers-uqpy/bin/python; \
		target/peers/bin/python benches/$$bench.py $(STICKSLIP) $$more || failed="$$failed $$bench"; \
	done; \
	[ -z "$$failed" ] || { echo "not finished or in disagreement:$$failed"; exit 1; }

clean:
	$(CARGO) clean
