#pragma once
// What start_once.cc and programs.cc exchange.
namespace vdbcloud::test {

struct Answer {
    int status = 0;      ///< as in a shell: 128 + N after signal N
    double seconds = 0;  ///< processor time
    double bytes = 0;    ///< peak of resident memory
};

}  // namespace vdbcloud::test
