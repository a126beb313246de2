# What the families of benchmarks share. A family (its folder's Makefile) says which media it solves on which rungs, and
# names the rows that it makes: $(results), one file for each run. Together they are $(OUT)/results.csv:
#
#   case,quantity,place,rung,voxel,ours,noise,seconds
#
# noise is the standard error of ours, 0 where there is none; seconds is processor time. published.csv holds what others
# published, with its source. The table that joins both is ../Makefile's.
BIN ?= ../../../build/bin
include ../../rules.mk
bench := source ../rows.sh;
# Commas inside $(call): a comma, and three equal edges of a voxel.
, := ,
cube = $(1),$(1),$(1)

all: $(OUT)/results.csv
	@:
$(OUT)/results.csv: $(results)
	@{ echo 'case,quantity,place,rung,voxel,ours,noise,seconds'; cat /dev/null $^; } > $@
