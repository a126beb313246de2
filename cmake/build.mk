# How a Makefile gets the programs: packages, configuration, build. Included by pipelines/ and tests/, which set TOP.
#
#   BUILD=folder    build folder (default: build/ of the tree)
#   JOBS=n          processor cores to use (default: all)
#   WERROR=ON       compiler warnings are errors, as in .ci/run
.DEFAULT_GOAL := all
BUILD  ?= $(TOP)/build
JOBS   ?= $(shell nproc)
WERROR ?=

# Packages are looked at again only when their list changes.
$(BUILD)/packages.stamp: $(TOP)/packages.txt $(TOP)/cmake/install-packages.sh
	@mkdir -p $(@D)
	@$(TOP)/cmake/install-packages.sh $<
	@touch $@

# A build folder that was configured with other warnings is configured again.
configured = $(if $(filter-out $(file < $(BUILD)/werror),$(WERROR)),FORCE)
$(BUILD)/build.ninja: $(BUILD)/packages.stamp $(configured)
	@printf "configuring %s\n" "$$(realpath -m -- $(call q,$(BUILD)))"
	@cmake -G Ninja -S $(TOP) -B $(BUILD) -DCMAKE_BUILD_TYPE=Release $(if $(WERROR),-DCMAKE_COMPILE_WARNING_AS_ERROR=$(WERROR)) \
	    > $(BUILD)/configure.log 2>&1 || { cat $(BUILD)/configure.log; exit 1; }
	@printf '%s' '$(WERROR)' > $(BUILD)/werror
	@touch $@

# $(call ninja,TARGETS): builds, and says nothing when nothing is out of date.
define ninja
@$(TOP)/cmake/ninja.sh $(BUILD) $(JOBS) $(1)
endef

.PHONY: FORCE
FORCE:
