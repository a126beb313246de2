# How each kind of file is made from the others. A pipeline says only where density comes from and which pictures it
# wants; see pipelines/*/Makefile. Stages meet in files: each takes one input that holds everything so far.
#
#   density --illuminate--> light [--p1solve--> scatter] --render--> exr, png
#
# Parameters live in .toml files beside the Makefile, so changing one makes again what used it and nothing else. A
# pipeline that has a scatter.toml goes through multiple scattering.
PICTURE ?= full
BIN     ?= ../../build/bin
OUT     ?= out$(if $(filter small,$(PICTURE)),/small)
THREADS ?= 0
FLAGS   ?= --quiet --threads $(THREADS)
LAUNCH  ?=

ifeq ($(PICTURE),small)
density_flags ?= --size 64
render_flags  ?= --resolution 128x128
endif

SHELL := bash
.SHELLFLAGS := -eu -o pipefail -c
# A tool that fails leaves no target; no intermediate grid is thrown away.
.DELETE_ON_ERROR:
.SECONDARY:
MAKEFLAGS += --no-builtin-rules

# The tools are order-only: a rebuild does not restart a night of rendering (make STRICT=1 when it should).
tool = $(if $(STRICT),$(BIN)/$(1),| $(BIN)/$(1))
# $(call stage,COMMAND): runs it, and leaves the seconds it took beside the target, by which `seconds` tells them.
stage = mkdir -p $(@D); TIMEFORMAT=%R; { time $(LAUNCH) $(BIN)/$(1) $(FLAGS) 2>&3; } 3>&2 2> $(basename $@)$(suffix $@).seconds

lit := $(if $(wildcard scatter.toml),scatter,light)

$(OUT)/%.light.vdb: $(OUT)/%.density.vdb light.toml $(call tool,illuminate)
	@$(call stage,illuminate $< --config light.toml $(light_flags) -o $@)

$(OUT)/%.scatter.vdb: $(OUT)/%.light.vdb scatter.toml $(call tool,p1solve)
	@$(call stage,p1solve $< --config scatter.toml -o $@)

$(OUT)/%.exr $(OUT)/%.png &: $(OUT)/%.$(lit).vdb camera.toml $(call tool,render)
	@$(call stage,render $< --config camera.toml $(render_flags) -o $(OUT)/$*.exr --png $(OUT)/$*.png)
	@printf '%s\n' "$(abspath $(OUT)/$*.png)"
	@for s in $(OUT)/$*.density.vdb $(OUT)/$*.light.vdb $(OUT)/$*.scatter.vdb $(OUT)/$*.exr $(OUT)/$*.png; do \
	    if [ -e $$s.seconds ]; then printf '  %-24s %s s\n' $$(basename $$s) $$(cat $$s.seconds); fi; done

$(BIN)/%:
	$(error $@ is not built: run make -C pipelines, or set BIN)

.PHONY: all clean why
clean:
	rm -rf out
why:  # what would run, and what made it necessary
	@$(MAKE) --dry-run --debug=basic all | grep -E 'Must remake|$(notdir $(BIN))/' | grep -v "'all'" || echo 'up to date'
