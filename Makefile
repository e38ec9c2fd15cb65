# The short way to everything: `make` lists what there is.

PREFIX ?= /usr/local
TARGET := $(or $(CARGO_TARGET_DIR),target)
CAUSTICA := $(TARGET)/release/caustica

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help setup build denoiser render test lint shape check-docs crosscheck hard-cases convergence fuzz sanitize bench study accuracy docs-figures instructions install clean gallery slurm-test deny

help: ## List these targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-12s %s\n", $$1, $$2 }' Makefile

setup: ## Get what the build needs: compiler, libclang, Rust, Embree 4
	@scripts/setup.sh

build: setup ## Build the program, optimised
	cargo build --release --locked

OIDN_DIR ?= $(CURDIR)/tools/oidn
denoiser: setup ## Build the program with `render --denoise`, by Open Image Denoise, and test that
	scripts/oidn.sh
	OIDN_DIR=$(OIDN_DIR) cargo test --locked --features oidn --test denoise
	OIDN_DIR=$(OIDN_DIR) cargo build --release --locked --features oidn

data/surface.obj: | build
	$(CAUSTICA) surface $@

render: build data/surface.obj ## Render the course's water scene into out/
	mkdir -p out
	$(CAUSTICA) render data/course_water.toml -o out/course_water.exr --passes 64 \
		--every-pass out/passes --direct out/course_water_direct.exr

gallery: build data/surface.obj ## Render every scene of data/ into docs/gallery.md
	python3 scripts/data_pictures.py
	python3 scripts/gallery.py

test: setup ## Run all tests
	cargo test --locked

lint: setup ## Check format, lints and documentation
	cargo fmt --check
	cargo clippy --locked --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --locked --no-deps

shape: setup ## Tell how long functions are: median, 90th percentile, longest
	cargo test --locked --test architecture functions_are_short -- --nocapture

check-docs: setup ## Check that links, targets and sub-commands in the documents exist
	cargo build --locked
	scripts/check_docs.py $(TARGET)/debug/caustica
	scripts/hard_cases.py --check
	scripts/docs_figures.py --check

deny: setup ## Check licences, sources and versions of the dependencies, by cargo-deny (installed into tools/ if missing)
	command -v cargo-deny >/dev/null || [ -x tools/bin/cargo-deny ] || cargo install --locked --debug --root tools cargo-deny
	PATH="$$PATH:$(CURDIR)/tools/bin" cargo deny --locked check bans licenses sources

crosscheck: build ## Hold pictures against what oiiotool, exrheader, OpenEXR and Mitsuba read in them
	scripts/crosscheck.sh $(CAUSTICA)

slurm-test: build ## Render by a Slurm of one node, break it on the way, and compare bytes; needs root
	python3 scripts/slurm_test.py $(CAUSTICA)

hard-cases: setup ## Run the hard cases, and write their table into docs/hard-cases.md
	scripts/hard_cases.py --update

convergence: setup ## Hold the rates at which variance and bias fall against theory, in minutes
	cargo test --locked --test hard_cases -- --ignored --nocapture both_fall

FUZZ_SECONDS ?= 20
fuzz: setup ## Fuzz every loader for FUZZ_SECONDS (20); needs nightly Rust and cargo-fuzz
	scripts/fuzz.sh $(FUZZ_SECONDS)

sanitize: setup ## Look for wrong memory accesses in the SIMD kernels; needs nightly Rust and valgrind
	scripts/sanitize.sh

bench: build data/surface.obj ## Measure the photon pass, the gathering and the rays, in a few minutes
	mkdir -p out
	$(CAUSTICA) bench --pass data/course_diffuse.toml --html out/bench_pass.html
	$(CAUSTICA) bench --gather --points 1e5,1e6 --radii 0.1,0.4,1,5 --repetitions 3 --html out/bench_gather.html
	$(CAUSTICA) bench --gather --scene data/course_water.toml --points 1e5,1e6 --radii 0.1,0.4 --repetitions 3 \
		--html out/bench_gather_water.html
	$(CAUSTICA) bench --rays --triangles 36,131072 --repetitions 3 --html out/bench_rays.html

study: build data/surface.obj ## Measure what accuracy costs in the water scene, in seven minutes, into out/study/
	$(CAUSTICA) study data/course_water.toml --make-reference -o out/study

accuracy: build data/surface.obj ## Hold the errors that renders claim against references, in five minutes
	scripts/accuracy_table.py $(CAUSTICA) out/accuracy

docs-figures: build data/surface.obj ## Measure all figures of the documents anew, on quiet cores, in about an hour
	python3 scripts/docs_figures.py
	scripts/hard_cases.py --update
	python3 scripts/gallery.py

instructions: setup ## Count the instructions of kernels by callgrind
	scripts/count_instructions.py

SHARE = $(DESTDIR)$(PREFIX)/share
# The system's Embree and that of EMBREE_DIR stay where they are; the private one goes along.
install: build ## Install program, manual pages and completions into PREFIX (/usr/local)
	install -D -m 755 $(CAUSTICA) $(DESTDIR)$(PREFIX)/bin/caustica
	$(CAUSTICA) man $(SHARE)/man/man1
	install -d $(SHARE)/bash-completion/completions $(SHARE)/zsh/site-functions $(SHARE)/fish/vendor_completions.d
	$(CAUSTICA) completions bash >$(SHARE)/bash-completion/completions/caustica
	$(CAUSTICA) completions zsh >$(SHARE)/zsh/site-functions/_caustica
	$(CAUSTICA) completions fish >$(SHARE)/fish/vendor_completions.d/caustica.fish
	if [ -z "$$EMBREE_DIR" ] && [ -d .embree ]; then \
		install -D -m 644 -t $(DESTDIR)$(PREFIX)/lib .embree/lib/*.so.*; \
	fi

clean: ## Remove what was built, but not what was rendered
	cargo clean
	rm -rf .embree .embree.partial data/surface.obj
