// A source for the target that precompiles headers for all tests.
#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>
