# `cmake --install`: a relocatable tree, with libculm for other programs; CPack's package.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# Libraries and headers of the layers: find_package(culm), then link culm::run and its like.
set(culm_package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/culm)
set(culm_libraries culm_build_flags)
foreach(layer core physics integrate measure archive farm run reduce study cluster fit residuals diagnose calibrate present)
    if(TARGET culm_${layer})
        list(APPEND culm_libraries culm_${layer})
        set_target_properties(culm_${layer} PROPERTIES EXPORT_NAME ${layer})
        install(DIRECTORY src/${layer} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/culm
            COMPONENT libraries FILES_MATCHING PATTERN "*.hpp")
    endif()
endforeach()
install(TARGETS ${culm_libraries} EXPORT culmTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/culm COMPONENT libraries)
install(EXPORT culmTargets NAMESPACE culm:: DESTINATION ${culm_package_folder} COMPONENT libraries)
configure_package_config_file(cmake/culmConfig.cmake.in ${PROJECT_BINARY_DIR}/culmConfig.cmake
    INSTALL_DESTINATION ${culm_package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/culmConfigVersion.cmake
    COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/culmConfig.cmake ${PROJECT_BINARY_DIR}/culmConfigVersion.cmake
    cmake/FindLibdeflate.cmake
    cmake/FindOpenCvModules.cmake
    DESTINATION ${culm_package_folder} COMPONENT libraries)

install(DIRECTORY config jobs DESTINATION ${CMAKE_INSTALL_DATADIR}/culm USE_SOURCE_PERMISSIONS)
install(DIRECTORY docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES README.md CHANGELOG.md CITATION.cff LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)

set(CPACK_PACKAGE_NAME culm)
set(CPACK_PACKAGE_VENDOR "the culm authors")
set(CPACK_PACKAGE_CONTACT "the culm authors <culm@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "calibration of flexible-stem discrete-element models")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_STRIP_FILES ON)
set(CPACK_GENERATOR DEB)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "openmpi-bin")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3, python3-h5py, python3-matplotlib, python3-numpy, python3-scipy")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "libjs-d3")
include(CPack)
