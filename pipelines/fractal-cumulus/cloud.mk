# A fractal cumulus as a pipeline whose folder has scene.toml, and density.toml where its cloud is another; the picture has the folder's name. 16:9.
# The density fills a body that envelope.toml describes, where that stands beside density.toml.
.PHONY: all
all:
# Three sweeps, unless RUNG or ERROR say otherwise.
ifeq ($(value ERROR),)
RUNG ?= 2
endif
ifeq ($(PICTURE),small)
render_flags := --resolution 160x90 $(small_flags)
endif
scattering := yes
include ../rules.mk
cloud    := $(OUT)/$(folder_name)
density  := $(or $(wildcard density.toml),../fractal-cumulus/density.toml)
envelope := $(wildcard $(dir $(density))envelope.toml)
body     := $(if $(envelope),$(cloud).envelope.vdb)
all: $(cloud).png

$(cloud).envelope.vdb: $(envelope) $(call tool,fractalgen)
	@$(call stage,fractalgen --config $(envelope) $(density_flags) -o $@)

$(cloud).density.vdb: $(density) $(body) $(call tool,fractalgen)
	@$(call stage,fractalgen --config $(density) $(density_flags) $(body:%=--envelope-from %) -o $@)
