# A fractal cumulus as a pipeline whose folder has scene.toml; the picture has the folder's name. Pictures are 16:9.
.PHONY: all
all:
# Three sweeps, unless RUNG or ERROR say otherwise.
ifeq ($(value ERROR),)
RUNG ?= 2
endif
ifeq ($(PICTURE),small)
render_flags := --resolution 160x90
endif
scattering := yes
include ../rules.mk
cloud   := $(OUT)/$(notdir $(CURDIR))
density := ../fractal-cumulus/density.toml
all: $(cloud).png

$(cloud).density.vdb: $(density) $(call tool,fractalgen)
	@$(call stage,fractalgen --config $(density) $(density_flags) -o $@)
