# find_package(lipoid) for others: lipoid::model and lipoid::identify.
include(CMakePackageConfigHelpers)
set(lipoid_package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/lipoid")
configure_package_config_file("${CMAKE_CURRENT_LIST_DIR}/lipoid-config.cmake.in"
                              "${PROJECT_BINARY_DIR}/lipoid-config.cmake"
                              INSTALL_DESTINATION "${lipoid_package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/lipoid-config-version.cmake"
                                 COMPATIBILITY SameMinorVersion)
install(EXPORT lipoid-targets NAMESPACE lipoid:: DESTINATION "${lipoid_package_dir}"
        COMPONENT development)
install(FILES "${PROJECT_BINARY_DIR}/lipoid-config.cmake"
              "${PROJECT_BINARY_DIR}/lipoid-config-version.cmake"
              "${CMAKE_CURRENT_LIST_DIR}/LipoidDependencies.cmake"
        DESTINATION "${lipoid_package_dir}" COMPONENT development)
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" "${PROJECT_SOURCE_DIR}/README.md"
        DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT development)
