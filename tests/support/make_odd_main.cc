// make_odd FOLDER: writes the odd files of data/odd.
#include "support/make_odd.h"

#include <iostream>

int main(int argc, char** argv)
{
    if (argc != 2) {
        std::cerr << "usage: make_odd FOLDER\n";
        return 2;
    }
    vdbcloud::test::make_odd_files(argv[1]);
}
