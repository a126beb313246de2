# A fractal cumulus as a pipeline whose folder has scene.toml, and density.toml where its cloud is another; the picture has the folder's name. 16:9.
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
cloud   := $(OUT)/$(notdir $(CURDIR))
density := $(or $(wildcard density.toml),../fractal-cumulus/density.toml)
all: $(cloud).png

$(cloud).density.vdb: $(density) $(call tool,fractalgen)
	@$(call stage,fractalgen --config $(density) $(density_flags) -o $@)
