# The Debian package, made by `make package` (scripts/package.sh): command, libraries, headers, CMake and pkg-config files, manual
# pages, completion and the examples of apps. What has the component `demo` is left out, for it needs OpenCV.
include(GNUInstallDirs)
set(documents ${CMAKE_INSTALL_DATADIR}/doc/catan)
install(DIRECTORY ${PROJECT_BINARY_DIR}/manual/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 OPTIONAL)
install(FILES packaging/catan.bash-completion DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME catan)
install(DIRECTORY apps/navigation apps/vr DESTINATION ${documents}/examples FILES_MATCHING PATTERN *.yaml
        PATTERN worlds EXCLUDE)
file(GLOB pages docs/*.md)
install(FILES ${pages} DESTINATION ${documents}/docs)
install(DIRECTORY docs/images DESTINATION ${documents}/docs)
install(FILES packaging/copyright DESTINATION ${documents} COMPONENT package)
install(DIRECTORY ${PROJECT_BINARY_DIR}/changelogs/ DESTINATION ${documents} COMPONENT package OPTIONAL)

# All that is installed, and nothing else: what `make package` builds.
get_property(modules GLOBAL PROPERTY CATAN_MODULES)
list(FILTER modules INCLUDE REGEX "^[a-z]+:")
list(TRANSFORM modules REPLACE "^([a-z]+):.*" "catan_\\1")
add_custom_target(package_contents DEPENDS catan catan_c ${modules})
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME catan)
set(CPACK_PACKAGE_CONTACT "The authors of Catan <catan@example.org>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL Unspecified package)
set(CPACK_COMPONENTS_GROUPING ALL_COMPONENTS_IN_ONE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION utils)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/packaging/triggers)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS
  "cmake, g++, gnuplot-nox, libeigen3-dev, libfmt-dev, libsqlite3-dev, libyaml-cpp-dev, nlohmann-json3-dev")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "run-time CPU scheduling for sense-react applications")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
"Catan decides at what rates and on which cores the nodes of a robot, a
vehicle or a headset run, so that they react as soon as they can, and
schedules them by that plan while they run. This package has the command,
the library libcatan for C and other languages, and the static libraries and
headers for C++.")
include(CPack)
