# libdeflate: Debian 12 ships no configuration file for CMake. Defines libdeflate::libdeflate.
include(FindPackageHandleStandardArgs)
find_path(Libdeflate_INCLUDE_DIR libdeflate.h)
find_library(Libdeflate_LIBRARY deflate)
if(Libdeflate_INCLUDE_DIR)
    file(STRINGS ${Libdeflate_INCLUDE_DIR}/libdeflate.h _libdeflate_line
        REGEX "#define LIBDEFLATE_VERSION_STRING")
    string(REGEX REPLACE "[^0-9.]" "" Libdeflate_VERSION "${_libdeflate_line}")
endif()
find_package_handle_standard_args(Libdeflate
    REQUIRED_VARS Libdeflate_LIBRARY Libdeflate_INCLUDE_DIR VERSION_VAR Libdeflate_VERSION)
if(Libdeflate_FOUND AND NOT TARGET libdeflate::libdeflate)
    add_library(libdeflate::libdeflate UNKNOWN IMPORTED)
    set_target_properties(libdeflate::libdeflate PROPERTIES
        IMPORTED_LOCATION ${Libdeflate_LIBRARY}
        INTERFACE_INCLUDE_DIRECTORIES ${Libdeflate_INCLUDE_DIR})
endif()
mark_as_advanced(Libdeflate_INCLUDE_DIR Libdeflate_LIBRARY)
