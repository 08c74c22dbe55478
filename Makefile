# What a person types; `make` alone lists it. CMake does the building, this file the steps around it.
SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
MAKEFLAGS += --no-print-directory
JOBS ?= $(shell nproc)

# Debian 12 packages, by what they are for.
BUILD_PACKAGES := cmake ninja-build g++ ccache pkg-config libgrpc++-dev libgrpc-dev protobuf-compiler \
  protobuf-compiler-grpc libprotobuf-dev libabsl-dev libhwy-dev prometheus-cpp-dev libcivetweb-dev libcli11-dev \
  libspdlog-dev liblzf-dev libpng-dev libssl-dev libeigen3-dev libnanoflann-dev nlohmann-json3-dev libcairo2-dev libpango1.0-dev \
  zlib1g-dev fonts-dejavu-core
DEB_PACKAGES := dpkg-dev python3
WHEEL_PACKAGES := protobuf-compiler python3 python3-pip python3-setuptools python3-wheel
GO_PACKAGES := golang-go golang-google-grpc-dev golang-github-golang-protobuf-1-5-dev protoc-gen-go protoc-gen-go-grpc
# 45 MB, 15 s to install.
ENGINE_PACKAGES := parallel python3-distributed slurm-wlm munge python3-kubernetes
TEST_PACKAGES := libgtest-dev libgmock-dev libbenchmark-dev libcgal-dev grpc-proto \
  python3 python3-grpcio python3-protobuf python3-numpy python3-matplotlib python3-pil python3-yaml curl ca-certificates \
  prometheus procps libfaketime openssl binutils python3-pandas $(WHEEL_PACKAGES) $(DEB_PACKAGES) \
  lld lintian systemd man-db git zsh fish locales fonts-lohit-deva chromium $(GO_PACKAGES) $(ENGINE_PACKAGES)
CHECK_PACKAGES := mypy clang-format clang-tidy clang libclang-rt-14-dev
# Another Node.js than Debian's is as good.
NODE_PACKAGES = $(shell command -v node >/dev/null || echo nodejs) $(shell command -v npm >/dev/null || echo npm)

# Installs those of the packages $(1) that are missing; says nothing if none is. Where another apt runs it waits for up to ten
# minutes: apt itself waits for dpkg's lock if it is told to, and never for that of the lists.
APT_PAUSE := 5
install = @missing=$$(for p in $(1); do \
    [ "$$(dpkg-query -W -f='$${db:Status-Status}' $$p 2>/dev/null)" = installed ] || echo $$p; done); \
  [ -n "$$missing" ] || exit 0; \
  as_root=$$([ "$$(id -u)" = 0 ] || echo sudo); \
  echo "Installing:" $$missing; \
  for try in {1..120}; do \
    said=$$($$as_root env LC_ALL=C apt-get update -qq 2>&1) && break; \
    grep -q 'Could not get lock' <<<"$$said" || { echo "$$said" >&2; exit 1; }; \
    [ $$try != 1 ] || echo 'Waiting for another apt to end'; \
    sleep $(APT_PAUSE); \
  done; \
  $$as_root env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=600 install -qq --no-install-recommends \
    $$missing </dev/null >/dev/null

# Runs the tests of preset $(1), one more at a time than there are processors, since many of them wait; under the thread
# sanitizer, where they are slow, no more than there are processors. The log is what .ci/run sums up.
ctest = ctest --preset $(1) --parallel $$(($(JOBS) + $(if $(filter tsan,$(1)),0,1))) --timeout 300 --no-tests=error $(2) | tee build/$(1)/ctest.log
BUF := build/tools/buf/node_modules/.bin/buf
SOURCES = $(wildcard proto/*.cc proto/*.h) $(shell find about core server client tests bench -name '*.cc' -o -name '*.h')

.PHONY: help
help: ## List what can be made
	@sed -nE 's/^([a-z0-9-]+):.*## (.*)/make \1\t\2/p' $(MAKEFILE_LIST) | expand -t 22

.PHONY: deps build-deps
deps: build-deps ## Install the Debian packages that building, testing and checking need
	$(call install,$(TEST_PACKAGES) $(CHECK_PACKAGES) $(NODE_PACKAGES))

build-deps: ## Install the Debian packages that building curvd and curv needs
	$(call install,$(BUILD_PACKAGES))

.PHONY: release
release: build-deps ## Build what ships: build/release/bin/curvd and curv
	@cmake --preset release >/dev/null
	@cmake --build --preset release --parallel $(JOBS)

# Built from a copy, so that setuptools leaves nothing beside the sources. Needs no network.
DIST := dist
.PHONY: wheel
wheel: ## Build the Python client's wheel: dist/curvd_client-VERSION-py3-none-any.whl
	$(call install,$(WHEEL_PACKAGES))
	@copy=$$(mktemp -d) && trap 'rm -rf "$$copy"' EXIT && mkdir "$$copy/client" && \
	  cp -r client/python "$$copy/client/" && cp -r proto "$$copy/" && rm -rf "$$copy/client/python/build" && \
	  /usr/bin/python3 -m pip wheel --quiet --disable-pip-version-check --no-deps --no-build-isolation --no-index \
	    --wheel-dir "$(DIST)" "$$copy/client/python"
	@ls "$(DIST)"/curvd_client-*.whl

.PHONY: deb
deb: release ## Build Debian packages: dist/{curvd,curv,libcurvd-client-dev}_VERSION_ARCH.deb
	$(call install,$(DEB_PACKAGES))
	@deploy/debian/build.sh build/release "$(DIST)"

.PHONY: npm-package
npm-package: ## Build the Node.js client's package: dist/curvd-client-VERSION.tgz
	$(call install,$(NODE_PACKAGES))
	@mkdir -p "$(DIST)" && npm pack --silent --pack-destination "$$(realpath "$(DIST)")" ./client/node

.PHONY: demo
demo: release ## Stream a noisy cloud through a fresh curvd, evaluate and render it; results in demo/
	@deploy/demo.sh build/release/bin demo

# ON compiles several sources at a time: sooner from nothing, later after a change.
UNITY ?= OFF
.PHONY: test
test: deps proto-check ## Build with warnings as errors and run every test
	@cmake --preset dev -DCURVD_UNITY_BUILD=$(UNITY) -DCURVD_UNITY_TESTS=$(UNITY) >/dev/null
	@cmake --build --preset dev --parallel $(JOBS)
	@$(call ctest,dev)

# The tests of suite $(1) whose names begin with one of $(2). Without parentheses: of an expression with
# more than nine CTest makes none, and leaves out nothing.
tests = $(subst $() ,|,$(addprefix $(1).,$(2)))

# What no sanitizer sees: counts of steps and of bytes, how a process ends, and how good numbers are, of which a test that looks
# for less runs the same code. Each kernel is run for AVX2 and as scalar code; that tiles have the bytes of the whole, for AVX2 alone.
COUNTS := HostileWorkTest|ScratchNeverHoldsMoreThanItsBound|PeakStaysBelow|PeakWithEstimatedNormals
ENDS := OpenSslDeathTest
JUDGEMENTS := $(call tests,AutomaticSeamsTest,Points What Counts Choices TheCaller)|$\
  $(call tests,AutomaticSurfacesTest,ANoisyTorus Lines NoiseDoes)|$(call tests,AutomaticTest,Copies ExactPoints NoiseInOneHalf NoiseOf ScalesFar)|$\
  $(call tests,FittedNormalsTest,AreMade Errors GoodOnes Jets NormalsOf NormalsThatAre)|$(call tests,JetProbeTest,Other)|$\
  $(call tests,MadeNormalsTest,ErrorsThat Estimates)|$(call tests,NoiseProbeTest,Bends Other)|$\
  $(call tests,NoisyPartsTest,EachPart Narrow Neighborhoods NoRepair Nothing OnePoint)|$\
  $(call tests,OrientationSidesTest,Noisy)|$(call tests,OwnFitsTest,AFewFlipped ASmallBody Counts KeepsTo NoiseIs)|$\
  $(call tests,OutlierRunTest,ANoisy Copies OutliersAmong OutliersBeside OutliersOfClouds Single Surfaces WrongNormals)|$\
  $(call tests,PointChoicesTest,Standard)|$(call tests,NormalPilotTest,Chooses Copies CurvatureIs FindsTheNoise NormalsAlone Rough ScanLines Strips)|$\
  $(call tests,ScaleTest,APlane ComesNearer TwoDensities)|$(call tests,SeamPhaseTest,Knife No Spheres TheSheets)|$\
  NanoflannTest|FlippedPointsAreNeverTrusted|IsNearTheBestOfAllFixedScales|NineInTenIntervalsHoldTheTruth|NoiseIsNotTakenForTwoSheets
NARROWER_TILES := TilesTest.*/SCALAR
# Whether threads change a byte is looked for on many of them, which the thread sanitizer watches; other tests run the same code alone.
SAME_BYTES := AutomaticSeamsTest.Threads|AutomaticTest.NeitherThreads|PointChoicesTest.NeitherThreads|NormalsJobTest.Threads|OwnFitsTest.TheSameBytes|$\
  OutlierPassesTest.NeitherThreads|FittedNormalsTest.Threads|NoisyPartsTest.Threads
NOT_SANITIZED := $(COUNTS)|$(ENDS)|$(JUDGEMENTS)|$(NARROWER_TILES)

.PHONY: asan
asan: deps ## Run the tests under the address and undefined behavior sanitizers
	@cmake --preset asan >/dev/null
	@cmake --build --preset asan --parallel $(JOBS)
	@$(call ctest,asan,--label-exclude 'languages|slow|fault' --exclude-regex '$(NOT_SANITIZED)|$(SAME_BYTES)')

# What repeats, for other estimators and other clouds, phases of a job that other tests run on several threads. Of the
# estimators EstimationJobTest.ThreadsDoNotChangeAByte runs each.
REPEATED_ON_THREADS := DeterminismTest.*/ESTIMATOR_(ALGEBRAIC|DELAUNAY|HEXAGRAM|INDEPENDENT|JET|NORMAL|UNIFORM)|HostileCloudTest|$\
  $(call tests,SeamPhaseTest,Flipped Noise Points Right Single)|$(call tests,OrientationSidesTest,Bowls Hostile Layouts TheRepair)|$\
  $(call tests,EstimationJobTest,PointsWithout Spheres WhatPages)|$(call tests,AutomaticTest,APlane LooksAcross)|AutomaticEdgesTest.Faces|$\
  OwnFitsTest.ADent|ScaleTest.AnOutlier

.PHONY: tsan
tsan: deps ## Run the tests of threaded code under the thread sanitizer, locks checked by clang
	@cmake --preset tsan >/dev/null
	@cmake --build --preset tsan --parallel $(JOBS)
	@$(call ctest,tsan,--label-exclude 'languages|slow|fault' --exclude-regex '$(NOT_SANITIZED)|$(REPEATED_ON_THREADS)')

# A server and clients as they ship, with the programs that break them.
FAULT_BIN := build/dev/bin
.PHONY: fault-programs fault guard tile-kills soak
fault-programs: deps
	@cmake --preset dev >/dev/null
	@cmake --build --preset dev --parallel $(JOBS) --target curvd curv curvd_python \
	  fault_callers fault_cancels fault_streams fault_fairness fault_soak

fault: fault-programs ## Try every fault TIMES times (20) against real processes, and 100,000 cancels; table in build/fault.md
	@tests/fault/run.sh $(FAULT_BIN) $(or $(TIMES),20) $(or $(CANCELS),100000) | tee build/fault.md

guard: fault-programs ## Try what bounds strangers TIMES times (20), ROW_SECONDS (900) a row at most, or ROW alone; table in build/guard.md
	@PYTHONPATH=$(FAULT_BIN)/../python /usr/bin/python3 tests/fault/run.py --programs $(FAULT_BIN) --guard --points 30000 \
	  --times $(or $(TIMES),20) --row-seconds $(or $(ROW_SECONDS),900) $(if $(ROW),"$(ROW)") | tee build/guard.md

tile-kills: fault-programs ## Kill servers, workers and drivers of engines that run tiles, KILLS (35) on each; table in build/tile-kills.md
	@PYTHONPATH=$(FAULT_BIN)/../python /usr/bin/python3 tests/engines/kill_trial.py --programs $(FAULT_BIN) --kills $(or $(KILLS),35) \
	  | tee build/tile-kills.md

soak: fault-programs ## Load and attack a server for DURATION (30m), compare every byte, look for growth
	@$(FAULT_BIN)/fault_soak --curvd=$(FAULT_BIN)/curvd --attacks=tests/fault/http2_attacks.py --duration=$(or $(DURATION),30m)

# For each fuzz target.
fuzz: SECONDS ?= 60
.PHONY: fuzz
fuzz: deps ## Run every fuzz target for SECONDS=60, or EXECUTIONS=1000000 times, under ASan and UBSan
	@cmake --preset fuzz >/dev/null
	@cmake --build --preset fuzz --parallel $(JOBS)
	@tests/fuzz/run_fuzzers.py build/fuzz/bin build/fuzz/run $(SECONDS) $(EXECUTIONS)

.PHONY: bench
bench: deps ## Run the benchmarks and rewrite docs/benchmarks.md (QUICK=1: small clouds, FULL=1: up to 10 million points)
	@cmake --preset bench >/dev/null
	@cmake --build --preset bench --parallel $(JOBS)
	@bench/run.sh build/bench $(if $(QUICK),--quick) $(if $(FULL),--full)

.PHONY: paper
paper: deps ## Make the paper's figures and tables again in docs/paper/ (QUICK=1: small clouds, few neighbor counts)
	@cmake --preset bench >/dev/null
	@cmake --build --preset bench --parallel $(JOBS) --target automatic_curves paper_cloud paper_errors paper_times curv
	@bench/paper/run.sh build/bench $(if $(QUICK),--quick)

.PHONY: format format-check
format: ## Format the C++ sources
	@clang-format -i $(SOURCES)

format-check: ## Fail where `make format` would change something
	@clang-format --dry-run -Werror $(SOURCES)

# The sources of what ships whose paths begin with $(1), but for those that a program wrote: sixteen in a file that includes them,
# so that headers are read the less often; or as the build in $(2) has them.
lint_sources = sed -nE '\|/proto/generated/|d; \|/page_template\.cc"|d; \|/laz_codec\.cc"|d; s@^ *"file": "($(1).*)",?$$@\1@p' $(or $(2),build/lint)/compile_commands.json

.PHONY: lint
lint: deps ## Run clang-tidy on the sources of what ships
	@cmake --preset lint >/dev/null
	@cmake --build build/lint --target curvd_generated curvd_commit_header >/dev/null
	@$(call lint_sources) | \
	  xargs -P $(JOBS) -n 1 clang-tidy -p build/lint --quiet 2> >(grep -vE '^[0-9]+ warnings? generated' >&2)

# A file of sixteen sources hides what one of them uses and another one includes. The compiler that builds reads each, and makes
# nothing of it. ALONE=client/ reads those of one folder.
ALONE ?=
.PHONY: lint-alone
lint-alone: deps ## Read each source of what ships by itself, as builds without unity do
	@cmake --preset lint -B build/alone -DCURVD_UNITY_BUILD=OFF >/dev/null
	@cmake --build build/alone --target curvd_generated curvd_commit_header >/dev/null
	@sed -nE '\|/proto/generated/|d; \|/page_template\.cc"|d; \|/laz_codec\.cc"|d; '\
's@^ *"command": "(.*) -o [^ ]+ -c ($(CURDIR)/$(ALONE).*)",$$@\1 -fsyntax-only \2@; T; s/\\(.)/\1/g; p' build/alone/compile_commands.json | \
	  xargs -d '\n' -P $(JOBS) -n 1 sh -c

.PHONY: lint-python
lint-python: deps ## Check the types of the Python client (mypy, strict)
	@cmake --preset dev >/dev/null
	@cmake --build --preset dev --parallel $(JOBS) --target curvd_python >/dev/null
	@/usr/bin/python3 -m mypy --config-file client/python/pyproject.toml build/dev/python/curvd_client

# The rest of curvd knows no processor. Debian's headers of these libraries serve every one. Sources are
# read as by lint. Those that name Eigen are compiled alone as well: one that misses a header of it compiles all the same, and links
# only where a neighbor in a file of sixteen includes that header.
ARM64_CXX := aarch64-linux-gnu-g++ -I. -isystem build/arm64/include -isystem build/arm64/include/eigen3 -std=c++20 -O0 -ffp-contract=off \
  -Wall -Wextra -Werror -Wno-psabi -DTOOLCHAIN_MISS_SYS_AUXV_H -DHWY_COMPILE_ONLY_STATIC
.PHONY: arm64
arm64: deps ## Compile the core for arm64
	$(call install,g++-aarch64-linux-gnu)
	@mkdir -p build/arm64/include
	@ln -sfn /usr/include/absl /usr/include/hwy /usr/include/eigen3 build/arm64/include/
	@cmake --preset lint >/dev/null
	@$(call lint_sources,$(CURDIR)/(build/lint/)?core/) | xargs -P $(JOBS) -I{} $(ARM64_CXX) -c {} -o /dev/null
	@rm -rf build/arm64/objects && mkdir build/arm64/objects
	@grep -rl --include='*.cc' Eigen core | xargs -P $(JOBS) -I{} \
	  sh -c '$(ARM64_CXX) -c {} -o build/arm64/objects/$$(echo {} | tr / _).o'
	@if aarch64-linux-gnu-nm -A --undefined-only build/arm64/objects/*.o | grep -E ' _ZNK?5Eigen' | c++filt; then \
	  echo 'What stands above has no body in these sources: they miss a header of Eigen'; exit 1; fi

.PHONY: proto-check proto-baseline
proto-check: $(BUF) ## Lint the contract and compare it with the one that clients rely on
	@$(BUF) lint
	@$(BUF) breaking --against proto/curvature.v1.binpb

proto-baseline: proto-check ## Make the present contract the one that clients rely on; never takes anything away
	@$(BUF) build --exclude-source-info -o proto/curvature.v1.binpb

$(BUF): proto/package.json proto/package-lock.json
	@mkdir -p build/tools/buf
	@cp proto/package.json proto/package-lock.json proto/.npmrc build/tools/buf/
	@cd build/tools/buf && npm ci --ignore-scripts --silent
	@touch $@

client/%/node_modules/.package-lock.json: client/%/package.json client/%/package-lock.json
	@cd client/$* && npm ci --ignore-scripts --silent
	@touch $@

.PHONY: report-page
report-page: client/report/node_modules/.package-lock.json ## Make the page of curv report again, client/report/page.html and laz_codec.html, of client/report/page/ and laz/
	@node client/report/build.mjs

# docker, podman or buildah; the latter two make OCI images, which know no health check, unless they are told.
CONTAINER_TOOL ?= $(notdir $(firstword $(foreach tool,docker podman buildah,$(shell command -v $(tool)))))
.PHONY: image
image: ## Build the container image curvd:latest (CONTAINER_TOOL=docker, podman or buildah)
	@$(CONTAINER_TOOL) build $(if $(filter docker,$(CONTAINER_TOOL)),,--format=docker) \
	  --build-arg CURVD_COMMIT="$$(git describe --always --dirty --abbrev=12 --match=v[0-9]* 2>/dev/null || true)" $(IMAGE_FLAGS) --tag curvd:latest .

.PHONY: image-test
image-test: ## Build the image and run it as deploy/ asks: as root, with buildah and podman; skipped without them
	@tests/deploy/image_test.sh

.PHONY: clean
clean: ## Remove what was built, and the demo's results
	@rm -rf build demo dist client/node/node_modules client/report/node_modules
