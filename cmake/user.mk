# Paths that the user gives to make. Included by pipelines/ and tests/.
#
# They are meant from where the user stands, make -C or not, and may have any name: they are read by $(value), which does
# not expand them, and handed to the shell by $(call q,...).
# VDBCLOUD_START is that folder: a make called by the user sets it, one called by another make of ours keeps it.
ifeq ($(MAKELEVEL),0)
VDBCLOUD_START := $(value PWD)
endif
VDBCLOUD_START ?= $(value PWD)
# From the environment, make would expand it as a name of its own.
VDBCLOUD_START := $(value VDBCLOUD_START)
export VDBCLOUD_START
# make would expand the value of a variable of its command line, $(shell ...) included, to hand it on in the environment.
$(foreach v,DENSITY VDBCLOUD_REAL VDBCLOUD_I3RC RUNG ERROR TIME,$(if $(findstring command,$(origin $(v))),$(eval unexport $(v))))

# $(call q,TEXT): one word of the shell.
q = '$(subst ','\'',$(1))'
define line_break


endef
# A line break ends a recipe, and make turns it into a space in what a shell prints.
$(foreach v,DENSITY VDBCLOUD_REAL VDBCLOUD_I3RC BIN OUT,$(if $(findstring $(line_break),$(value $(v))),$(error $(v) holds a line break: expected a path without one: rename the file, or give a link to it)))

# $(call absolute,PATH): of a path that is seen from here.
absolute = $(shell realpath -m -- $(call q,$(1)))
# $(call found,PATH), $(call folder,PATH): the absolute path of a file or folder of the user; nothing if there is none.
found = $(shell cd $(call q,$(VDBCLOUD_START)) 2> /dev/null; p=$(call q,$(1)); [ ! -f "$$p" ] || realpath -s -- "$$p")
folder = $(shell cd $(call q,$(VDBCLOUD_START)) 2> /dev/null; p=$(call q,$(1)); [ ! -d "$$p" ] || realpath -s -- "$$p")
