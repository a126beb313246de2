# How a Makefile gets the programs: packages, configuration, build. Included by pipelines/ and tests/, which set TOP.
.DEFAULT_GOAL := all
BUILD ?= $(TOP)/build
JOBS  ?= $(shell nproc)

# Packages are looked at again only when their list changes.
$(BUILD)/packages.stamp: $(TOP)/packages.txt $(TOP)/cmake/install-packages.sh
	@mkdir -p $(@D)
	@$(TOP)/cmake/install-packages.sh $<
	@touch $@

$(BUILD)/build.ninja: $(BUILD)/packages.stamp
	@echo "configuring $(abspath $(BUILD))"
	@cmake -G Ninja -S $(TOP) -B $(BUILD) -DCMAKE_BUILD_TYPE=Release > $(BUILD)/configure.log 2>&1 || { cat $(BUILD)/configure.log; exit 1; }
	@touch $@

# Ninja knows what is out of date; it says nothing when nothing is. $(call ninja,TARGETS)
define ninja
@if ! ninja -C $(BUILD) -n $(1) | grep -q 'no work to do'; then echo "building"; ninja -C $(BUILD) -j $(JOBS) --quiet $(1); fi
endef
