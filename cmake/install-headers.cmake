# Installs the public headers of the folder `from` below the folder `to`.
cmake_policy(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/public-headers.cmake)
find_public_headers(found ${from})
foreach(header IN LISTS found)
    get_filename_component(folder ${header} DIRECTORY)
    file(INSTALL ${from}/${header} DESTINATION ${to}/${folder})
endforeach()
