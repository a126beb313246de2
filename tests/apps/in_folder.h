#pragma once
// Commands of a shell in a folder that the tests of a suite share.
#include "support/run.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace vdbcloud::test {

/// A suite of tests with a folder of its own: `class Suite : public InFolder<Suite>`. `Suite::made`, a public text, is
/// the line that makes its files.
template<typename Suite>
class InFolder : public testing::Test {
protected:
    static void SetUpTestSuite()
    {
        folder_ = std::make_unique<Scratch>();
        expect_done(Suite::made);
    }
    static void TearDownTestSuite() { folder_.reset(); }

    static RunResult in_folder(const std::string& line)
    {
        RunOptions there;
        there.folder = folder_->path();
        return shell(line, there);
    }
    static RunResult expect_done(const std::string& line)
    {
        RunResult r = in_folder(line);
        EXPECT_EQ(r.status, 0) << line << "\n" << r.err;
        return r;
    }

    inline static std::unique_ptr<Scratch> folder_;
};

}  // namespace vdbcloud::test
