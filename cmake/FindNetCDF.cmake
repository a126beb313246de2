# The C library of netCDF: NetCDF::netcdf. Its own config package asks for the compilers and packages of HDF5.
find_path(NetCDF_INCLUDE_DIR netcdf.h)
find_library(NetCDF_LIBRARY netcdf)
mark_as_advanced(NetCDF_INCLUDE_DIR NetCDF_LIBRARY)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(NetCDF REQUIRED_VARS NetCDF_LIBRARY NetCDF_INCLUDE_DIR)
if(NetCDF_FOUND AND NOT TARGET NetCDF::netcdf)
    add_library(NetCDF::netcdf UNKNOWN IMPORTED)
    set_target_properties(NetCDF::netcdf PROPERTIES
        IMPORTED_LOCATION ${NetCDF_LIBRARY}
        INTERFACE_INCLUDE_DIRECTORIES ${NetCDF_INCLUDE_DIR})
endif()
