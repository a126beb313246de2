# How each kind of file is made from the one before it. A pipeline (pipelines/*/Makefile) says where density comes from
# and which pictures it wants. Each stage reads one file, which holds everything made so far, and writes one file.
#
#   density --illuminate--> light [--p1solve--> scatter] --render--> exr, png
#
# OUT/NAME.path.exr is the same picture by light paths (docs/path.md): PARTS jobs of SPP samples a pixel, merged.
#
# scene.toml beside the Makefile has medium, lights, sky, camera and so on (docs/scene.md); the density has a file of its own, if
# any, so that sources swap. Each program reads what it takes of the scene: OUT/PROGRAM.part. A change of one section makes
# again what takes it and nothing else. A Makefile that sets scattering computes multiple scattering.
#
#   RUNG=n          accuracy of the whole chain, from 0 to 6 (docs/rungs.md); what scene.toml says beats it. Pipelines that
#                   compare methods have settings of their own, and no rung
#   ERROR=2% TIME=s climbs the rungs from the cheapest, and stops at the first whose error over blocks of 32 x 32 pixels is
#                   at most ERROR, measured against light paths (climb.sh), in TIME seconds (default 600). RUNG beats ERROR
#   PICTURE=small   a small grid and a small picture       THREADS=n   threads of each program (0: all)
#   SPP=n PARTS=n   samples a pixel of each job, and jobs, of NAME.path.exr
#   OUT=folder      where files go (default: out)          STRICT=1    a program that was rebuilt makes its files again
#
# A variable that changes what a program is told makes its files again, too: OUT/PROGRAM.told holds what it was told last.
# Files of the user may have any name (cmake/user.mk): links of plain names stand for them in OUT.
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

TIME    ?= 600
rules   := $(dir $(lastword $(MAKEFILE_LIST)))

SHELL := bash
.SHELLFLAGS := -eu -o pipefail -c
include $(rules)../cmake/user.mk
# $(call given,VARIABLE): its value; as it stands where the user gave it.
given = $(if $(filter file,$(origin $(1))),$($(1)),$(value $(1)))
# The name of this pipeline's folder, which may stand in one whose name has spaces.
folder_name := $(lastword $(subst /, ,$(CURDIR)))
# $(call odd,VARIABLE): the characters of a path that keep it from being the name of a target.
odd = $(shell printf %s $(call q,$(call given,$(1))) | LC_ALL=C tr -d 'A-Za-z0-9_./+,=@~-')
# A folder that the user gives is meant from where the user stands; with PLACED, from a make of ours, from here.
of_user = $(if $(PLACED),,$(filter command% environment%,$(origin $(1))))
ifneq ($(and $(call of_user,BIN),$(filter-out /%,$(firstword $(call given,BIN)))),)
override BIN := $(shell cd -- $(call q,$(VDBCLOUD_START)) && realpath -m -- $(call q,$(call given,BIN)))
endif
ifneq ($(call odd,OUT),)
$(error OUT = '$(call given,OUT)': expected a path of letters, digits and _./+,=@~- only)
endif
ifneq ($(and $(call of_user,OUT),$(filter-out /%,$(firstword $(call given,OUT)))),)
override OUT := $(shell realpath -m --relative-to=. -- $(call q,$(VDBCLOUD_START))/$(call q,$(call given,OUT)))
ifneq ($(call odd,OUT),)
$(error OUT = '$(call given,OUT)', as seen from $(folder_name): expected a way of letters, digits and _./+,=@~- only: give an absolute path)
endif
endif
# What the rung says of p1solve: "none" where the picture needs no multiple scattering by p1solve.
ifneq ($(call given,RUNG),)
rung_file := $(rules)../data/rungs.txt
rungs := $(shell sed -n 's/^rung \([0-9]*\):.*/\1/p' $(rung_file))
ifneq ($(words $(call given,RUNG)) $(filter $(rungs),$(call given,RUNG)),1 $(strip $(call given,RUNG)))
$(error RUNG = '$(call given,RUNG)': expected one of $(rungs))
endif
rung_flags := --rung $(strip $(call given,RUNG))
rung_of_p1solve := $(shell awk -v n=$(RUNG) '$$1 == "p1solve" && $$2 == "--iterations" { print $$(n + 3) }' $(rung_file))
endif
# A rung decides whether there is multiple scattering, else the pipeline does.
lit := $(if $(if $(rung_flags),$(filter-out none,$(rung_of_p1solve)),$(scattering)),scatter,light)
# $(call told,FILE,TEXT): writes TEXT to OUT/FILE.told unless it is there. While make reads its files, so that why works.
told = $(if $(filter clean,$(MAKECMDGOALS)),,$(shell [ -d $(OUT) ] || mkdir -p $(OUT); f=$(OUT)/$(1).told; \
    [ -e $$f ] && [ "$$(< $$f)" = $(call q,$(2)) ] || printf '%s\n' $(call q,$(2)) > $$f))
# $(call density_of_user,NAME,PATH): makes OUT/NAME.density.vdb a link to the file, and what is made of it depend on which
# file it is, and on when it was written: one that is older than the last may take its place, under the same name too.
density_of_user = $(if $(filter clean,$(MAKECMDGOALS)),,$(call told,$(1).density,$(2) $(shell stat -L -c '%.Y %s' -- $(call q,$(2))))$(shell mkdir -p $(OUT); \
    [ "$$(readlink -- $(OUT)/$(1).density.vdb)" = $(call q,$(2)) ] || ln -sfn -- $(call q,$(2)) $(OUT)/$(1).density.vdb))
# A program that fails leaves no target. make keeps intermediate grids.
.DELETE_ON_ERROR:
.SECONDARY:
MAKEFLAGS += --no-builtin-rules

# Programs are order-only prerequisites: a rebuilt program does not start a night of rendering again, except with STRICT=1.
tool = $(OUT)/$(1).told $(if $(STRICT),$(BIN)/$(1),| $(BIN)/$(1))
# $(call stage,COMMAND): runs a program and writes the seconds that it took to TARGET.seconds.
stage = mkdir -p $(@D); TIMEFORMAT=%R; { time $(LAUNCH) $(BIN)/$(1) $(FLAGS) 2>&3; } 3>&2 2> $(basename $@)$(suffix $@).seconds

# A folder of programs whose name is no name of a target has a link.
ifneq ($(call odd,BIN),)
$(shell mkdir -p $(OUT); ln -sfn -- "$$(realpath -- $(call q,$(call given,BIN)))" $(OUT)/programs)
override BIN := $(OUT)/programs
endif
programs := $(shell realpath -- $(BIN) 2> /dev/null || echo $(BIN))
$(call told,fractalgen,$(programs) $(density_flags))
$(call told,illuminate,$(programs) $(rung_flags) $(light_flags))
$(call told,p1solve,$(programs) $(rung_flags))
$(call told,render,$(programs) $(rung_flags) $(render_flags) $(SPP) $(PARTS))
$(foreach p,vdbimport exrmerge,$(call told,$(p),$(programs)))

# $(call part,PROGRAM,SCENE,NAME): OUT/NAME.part holds what the program takes of a scene. It is replaced where that differs. The program
# is asked again when it or the scene is another file than OUT/NAME.part.of says, or was written since.
part = $(if $(filter clean,$(MAKECMDGOALS)),,$(shell f=$(OUT)/$(3).part; [ -d $(OUT) ] || mkdir -p $(OUT); \
    of=$$(stat -L -c '%n %i %s %.Y %.Z' $(2) $(BIN)/$(1) 2> /dev/null) || true; \
    if [ ! -x $(BIN)/$(1) ]; then touch $$f; \
    elif [ -e $$f ] && [ -e $$f.of ] && [ "$$(< $$f.of)" = "$$of" ]; then :; \
    elif $(BIN)/$(1) --scene $(2) --print-scene > $$f.new; then \
        cmp -s $$f.new $$f && rm $$f.new || mv $$f.new $$f; printf '%s\n' "$$of" > $$f.of; \
    else rm -f $$f.new; exit 1; fi)$(if $(filter-out 0,$(.SHELLSTATUS)),$(error $(2): refused by $(1))))
ifneq ($(wildcard scene.toml),)
$(foreach p,illuminate p1solve render,$(call part,$(p),scene.toml,$(p)))
# A list of effects without multiple scattering leaves p1solve nothing to do.
unsolved := $(shell sed -n 's/^effects = "\(.*\)"$$/\1/p' $(OUT)/p1solve.part 2> /dev/null | grep -vxE 'auto|all|(.*,)?multiple(,.*)?')
lit := $(if $(unsolved),light,$(lit))
endif

# $(call say,FILE): prints its absolute path.
say = realpath -s -- $(1)

$(OUT)/%.light.vdb: $(OUT)/%.density.vdb $(OUT)/illuminate.part $(call tool,illuminate)
	@$(call stage,illuminate $< --scene scene.toml $(rung_flags) $(light_flags) -o $@)

$(OUT)/%.scatter.vdb: $(OUT)/%.light.vdb $(OUT)/p1solve.part $(call tool,p1solve)
	@$(call stage,p1solve $< --scene scene.toml $(rung_flags) -o $@)

ifneq ($(and $(call given,ERROR),$(if $(call given,RUNG),,no rung)),)
# Tries are made by other makes. This one runs none when it only lists commands.
make_again := $(MAKE)
.PHONY: always
always:
# climb.sh puts whole pictures in their place, or leaves those that are there.
.PRECIOUS: $(OUT)/%.exr $(OUT)/%.png
$(OUT)/%.exr $(OUT)/%.png &: always
	@$(rules)climb.sh $(make_again) $(BIN) $(OUT) $* $(call q,$(call given,ERROR)) $(call q,$(call given,TIME))
else
# climb.sh has the error measured, which does not change the picture. Status 3: not known as well as asked for.
$(OUT)/%.exr $(OUT)/%.png &: $(OUT)/%.$(lit).vdb $(OUT)/render.part $(call tool,render)
	@$(call stage,render $< --scene scene.toml $(rung_flags) $(render_flags) $(climb_flags) -o $(OUT)/$*.exr --png $(OUT)/$*.png)$(if $(climb_flags), || [ $$? = 3 ])
	@$(call say,$(OUT)/$*.png)
	@for s in $(OUT)/$*.density.vdb $(OUT)/$*.light.vdb $(if $(filter scatter,$(lit)),$(OUT)/$*.scatter.vdb) $(OUT)/$*.exr $(OUT)/$*.png; do \
	    if [ -e $$s.seconds ]; then printf '  %-24s %s s\n' $$(basename $$s) $$(cat $$s.seconds); fi; done
endif

# Each part has samples of its own, so that any machine may make it. LAUNCH may hand it to a batch system.
parts := $(shell seq 0 $$(($(PARTS) - 1)))
define path_part
$(OUT)/%.part$(1).exr: $(OUT)/%.$(lit).vdb $(OUT)/render.part $(call tool,render)
	@$$(call stage,render $$< --scene scene.toml $$(render_flags) --integrator path --spp $(SPP) \
	    --spp-offset $$$$(($(1) * $(SPP))) --aov standard_error -o $$@ --png $$(@:.exr=.png))
endef
$(foreach k,$(parts),$(eval $(call path_part,$(k))))

$(OUT)/%.path.exr: $(foreach k,$(parts),$(OUT)/%.part$(k).exr) $(call tool,exrmerge)
	@$(call stage,exrmerge $(filter %.exr,$^) -o $@)

$(BIN)/%:
	$(error $@ is not built: run make -C pipelines, or set BIN)

.PHONY: all clean why
clean:  # of this pipeline and of those beneath it
	rm -rf out */out
why:  # commands that would run, and the prerequisites that are newer
	@$(MAKE) --dry-run --debug=basic all | grep -E 'Must remake|$(notdir $(BIN))/' | grep -v "'all'" || echo 'up to date'
