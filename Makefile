# What a user types: `make run` and `make test`. Everything else is for developers.

CARGO  ?= cargo
PYTHON ?= python3
STICKSLIP = target/release/stickslip

.PHONY: run test check docs-pictures bench bench-peers validity coverage clean
.DEFAULT_GOAL := run

# Build, and run the main job: Figure 14a.
run:
	$(CARGO) build --locked --release
	$(STICKSLIP) submit jobs/fig14a.toml

# The tests. Those of the Python readers need Python with venv, those of the report a Chromium as well; without them they
# are left out, with a word about it.
test: target/readers/ready
	$(CARGO) build --locked
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
	$(CARGO) test --locked --release --workspace

target/readers/ready: tests/requirements.txt
	mkdir -p target/readers
	if $(PYTHON) -m venv target/readers \
	    && target/readers/bin/python -m pip install --quiet --disable-pip-version-check -r tests/requirements.txt; then \
	    touch $@; \
	else \
	    rm -rf target/readers; test -z "$$CI"; \
	fi

# Formatting, lints, documentation and the order of imports; all warnings are errors.
check:
	$(CARGO) fmt --all --check
	$(CARGO) test --locked --quiet -p stickslip-core --test structure
	$(CARGO) clippy --locked --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --locked --workspace --no-deps

# The figures of docs/reproduction.md, drawn by the program. Figure 14b, which takes minutes, is left out.
PICTURES = fig4 fig5 fig6 fig7 fig8 fig9 fig10 fig11 fig12 fig13 fig14a fig14c fig14d fig15a fig15b external

docs-pictures:
	$(CARGO) build --locked --release
	$(STICKSLIP) reproduce $(PICTURES) --out target/pictures > /dev/null
	mkdir -p docs/figures
	for name in $(PICTURES); do cp "target/pictures/$$name/$$name.svg" docs/figures/ || exit 1; done

# One line for each figure: name, value, unit.
bench:
	$(CARGO) bench --locked -p stickslip --bench figures --bench methods --bench inputs

# The tables of the range of validity (docs of `stickslip_core::criterion::validity`): verdicts against references, case by case.
validity:
	$(CARGO) bench --locked -p stickslip-core --bench validity

# The table of coverage: how often intervals contain the true value, by simulation.
coverage:
	$(CARGO) bench --locked -p stickslip-sampler --bench coverage

# The same jobs by NumPy, OpenTURNS, numba, SciPy and diffrax beside it.
bench-peers: target/peers/ready
	$(CARGO) build --locked --release
	target/peers/bin/python benches/peers.py $(STICKSLIP)
	target/peers/bin/python benches/peers_methods.py $(STICKSLIP)
	target/peers/bin/python benches/peers_time_domain.py $(STICKSLIP)
	target/peers/bin/python benches/peers_starts.py $(STICKSLIP)

target/peers/ready: benches/peers-requirements.txt
	$(PYTHON) -m venv target/peers
	target/peers/bin/python -m pip install --quiet --disable-pip-version-check -r benches/peers-requirements.txt
	touch $@

clean:
	$(CARGO) clean
