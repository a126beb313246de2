# How each kind of file is made from the one before it. A pipeline (pipelines/*/Makefile) says where density comes from
# and which pictures it wants. Each stage reads one file, which holds everything made so far, and writes one file.
#
#   density --illuminate--> light [--p1solve--> scatter] --render--> exr, png
#
# OUT/NAME.path.exr is the same picture by light paths (docs/path.md): PARTS jobs of SPP samples a pixel, merged.
#
# Parameters are in .toml files beside the Makefile: a change of one makes again what depends on it and nothing else. A
# pipeline that has a scatter.toml computes multiple scattering.
#
#   PICTURE=small   a small grid and a small picture       THREADS=n   threads of each program (0: all)
#   SPP=n PARTS=n   samples a pixel of each job, and jobs, of NAME.path.exr
#   OUT=folder      where files go (default: out)          STRICT=1    a program that was rebuilt makes its files again
PICTURE ?= full
BIN     ?= ../../build/bin
OUT     ?= out$(if $(filter small,$(PICTURE)),/small)
THREADS ?= 0
FLAGS   ?= --quiet --threads $(THREADS)
LAUNCH  ?=
SPP     ?= 64
PARTS   ?= 4

ifeq ($(PICTURE),small)
density_flags ?= --size 64
render_flags  ?= --resolution 128x128
endif

SHELL := bash
.SHELLFLAGS := -eu -o pipefail -c
# A program that fails leaves no target. make keeps intermediate grids.
.DELETE_ON_ERROR:
.SECONDARY:
MAKEFLAGS += --no-builtin-rules

# Programs are order-only prerequisites: a rebuilt program does not start a night of rendering again, except with STRICT=1.
tool = $(if $(STRICT),$(BIN)/$(1),| $(BIN)/$(1))
# $(call stage,COMMAND): runs a program and writes the seconds that it took to TARGET.seconds.
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

# Each part has samples of its own, so that any machine may make it. LAUNCH may hand it to a batch system.
parts := $(shell seq 0 $$(($(PARTS) - 1)))
define path_part
$(OUT)/%.part$(1).exr: $(OUT)/%.$(lit).vdb camera.toml $(call tool,render)
	@$$(call stage,render $$< --config camera.toml $$(render_flags) --integrator path --spp $(SPP) \
	    --spp-offset $$$$(($(1) * $(SPP))) --aov standard_error -o $$@)
endef
$(foreach k,$(parts),$(eval $(call path_part,$(k))))

$(OUT)/%.path.exr: $(foreach k,$(parts),$(OUT)/%.part$(k).exr) $(call tool,exrmerge)
	@$(call stage,exrmerge $(filter %.exr,$^) -o $@)

$(BIN)/%:
	$(error $@ is not built: run make -C pipelines, or set BIN)

.PHONY: all clean why
clean:
	rm -rf out
why:  # commands that would run, and the prerequisites that are newer
	@$(MAKE) --dry-run --debug=basic all | grep -E 'Must remake|$(notdir $(BIN))/' | grep -v "'all'" || echo 'up to date'
