// A source for the target that precompiles headers for all programs.
#include "vdbcloud/core/vdb.h"
