# `cpack` in a build folder makes a Debian package of the program, without libraries and headers:
# the component runtime. What it depends on is what the program is linked to. tools/deb-check
# installs it on a bare system.
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/lipoid"
        RENAME copyright COMPONENT runtime)
set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL runtime)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_VENDOR "the lipoid authors")
set(CPACK_PACKAGE_CONTACT "the lipoid authors <lipoid@localhost>")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME lipoid)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION science)
set(CPACK_DEBIAN_RUNTIME_FILE_NAME lipoid.deb)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUNTIME_DESCRIPTION "${PROJECT_DESCRIPTION}")
include(CPack)
