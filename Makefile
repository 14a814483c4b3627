# What people type. Everything here works from a fresh clone on Debian 12: packages that are missing are installed first
# (scripts/setup.sh). Builds go to build/PRESET, results to out/.
#
#   PRESET=debug    another preset of CMakePresets.json            JOBS=4      compile that many files at a time
#   SETUP=skip      do not look for packages                       VERBOSE=1   show what is run
#   TESTS=regex     only tests whose name matches
PRESET ?= release
JOBS   ?= $(shell nproc)
TESTS  ?= .
SETUP  ?=
BUILD  := build/$(PRESET)

ifndef VERBOSE
.SILENT:
quiet_configure := --log-level=WARNING >/dev/null
else
verbose_build := --verbose
endif
cmake_build = cmake --build build/$(1) --parallel $(JOBS) $(verbose_build)
# The test programs that cover the code which runs in several threads; others run the same code again.
THREADED := os_test doctor_test runtime_test api_test session_test face_tracking_test sim_test
link_command = mkdir -p bin && ln -sfn ../$(BUILD)/tools/catan/catan bin/catan
say = @printf '\n== %s\n' '$(1)'
sources = git ls-files '*.cpp' '*.h'

.DEFAULT_GOAL := help
.PHONY: help demo case-studies test test-steady build bench package format format-check lint lint-changed asan tsan fuzz clean setup setup-dev
# One thing at a time: each step uses all CPUs by itself.
.NOTPARALLEL:
.DELETE_ON_ERROR:

help: ## this list
	sed -n 's/^\([a-z-]*\):.*## \(.*\)/  make \1|\2/p' $(MAKEFILE_LIST) | column -t -s'|' 2>/dev/null || \
	  sed -n 's/^\([a-z-]*\):.*## \(.*\)/  make \1: \2/p' $(MAKEFILE_LIST)
	sed -n 's/^#   \(.*\)/    \1/p' $(MAKEFILE_LIST)

demo: build-demo ## build and run the demonstration; page out/demo/report.html, and the command is bin/catan
	$(call say,Demo)
	mkdir -p out/demo
	$(BUILD)/tools/demo/catan_demo $(DEMO_ARGS)

case-studies: build-case-studies ## run the case studies over night (CASE_STUDIES_ARGS=--quick: 10 minutes); page out/case-studies/report.html
	$(call say,Case studies)
	$(BUILD)/tools/case_studies/catan_case_studies $(CASE_STUDIES_ARGS)

test: build ## build everything and run all tests
	$(call say,Test)
	scripts/test.sh $(PRESET) $(JOBS) '$(TESTS)'

test-steady: build ## only the tests that do not depend on the clock
	$(call say,Test)
	SKIP_REALTIME=1 scripts/test.sh $(PRESET) $(JOBS) '$(TESTS)'

build: configure ## build everything; the command is then bin/catan
	$(call say,Build ($(PRESET)))
	$(call cmake_build,$(PRESET))
	$(link_command)

bench: build ## run the benchmarks
	$(call say,Benchmarks)
	cd $(BUILD)/bench && for b in ./*_bench; do "$$b" || exit 1; done

package: setup-dev configure ## make the Debian package, out/package/catan_*.deb
	$(call say,Package)
	$(call cmake_build,$(PRESET)) --target package_contents
	scripts/package.sh $(BUILD)

format: setup-dev ## format all C++ files in place
	$(sources) | xargs clang-format-14 -i

format-check: setup-dev ## fail if a C++ file is not formatted
	$(sources) | xargs clang-format-14 --dry-run --Werror

lint: setup-dev configure ## static analysis: clang-tidy and cppcheck
	$(call say,Lint)
	scripts/lint.sh $(BUILD) $(JOBS)

lint-changed: setup-dev configure ## the same of what differs from origin/main, or from the last commit
	$(call say,Lint)
	scripts/lint.sh --changed $(BUILD) $(JOBS)

asan: setup-dev ## run all tests under AddressSanitizer and UndefinedBehaviorSanitizer
	$(MAKE) --no-print-directory test PRESET=asan SETUP=skip

tsan: setup-dev ## run the tests of all that has threads under ThreadSanitizer
	$(MAKE) --no-print-directory configure PRESET=tsan SETUP=skip
	$(call say,Build (tsan))
	$(call cmake_build,tsan) --target $(THREADED)
	$(call say,Test)
	scripts/fixed-addresses.sh scripts/test.sh tsan $(JOBS) '$(TESTS)' programs

fuzz: setup-dev ## run each fuzzer for FUZZ_SECONDS (default 20)
	$(MAKE) --no-print-directory configure PRESET=asan SETUP=skip
	$(call say,Build (fuzzers))
	$(call cmake_build,asan) --target fuzzers
	scripts/fuzz.sh build/asan $(or $(FUZZ_SECONDS),20) $(JOBS)

clean: ## remove all that make made
	rm -rf build bin out

# --- parts of the above -------------------------------------------------------------------------------------------------
.PHONY: configure build-demo build-case-studies

setup:
	[ '$(SETUP)' = skip ] || scripts/setup.sh
setup-dev:
	[ '$(SETUP)' = skip ] || scripts/setup.sh --dev

configure: setup $(BUILD)/build.ninja
# Later changes of CMakeLists.txt files are Ninja's business; only those of the presets are not, and roscpp, if it was
# installed since.
$(BUILD)/build.ninja: CMakePresets.json $(wildcard /var/lib/dpkg/info/libroscpp-dev.list /var/lib/dpkg/info/libnodeletlib-dev.list)
	$(call say,Configure ($(PRESET)))
	cmake --preset $(PRESET) $(quiet_configure)
	touch $@

build-demo: configure
	$(call say,Build ($(PRESET)))
	$(call cmake_build,$(PRESET)) --target catan_demo face_tracking catan
	$(link_command)

build-case-studies: configure
	$(call say,Build ($(PRESET)))
	$(call cmake_build,$(PRESET)) --target catan_case_studies navigation vr
