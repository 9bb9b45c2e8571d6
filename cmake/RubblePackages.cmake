# What `cpack` makes: rubble_*.deb (the robot) and rubble-dev_*.deb (messages for other programs).
# Made by scripts/package.

install(TARGETS
  rubble rubble-camera rubble-console rubble-fusion rubble-lidar rubble-recognizer rubble-slam-lidar rubble-slam-mono
  rubble-stabilizer
  RUNTIME COMPONENT rubble)
file(GLOB config_files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/config/*.yaml)
install(FILES ${config_files} DESTINATION /etc/rubble COMPONENT rubble)
file(GLOB unit_files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/systemd/*.service ${PROJECT_SOURCE_DIR}/systemd/*.target)
install(FILES ${unit_files} DESTINATION lib/systemd/system COMPONENT rubble)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/systemd/rubble-.service.d DESTINATION lib/systemd/system COMPONENT rubble)
install(FILES ${PROJECT_SOURCE_DIR}/systemd/60-rubble.conf DESTINATION lib/sysctl.d COMPONENT rubble)
install(FILES ${PROJECT_SOURCE_DIR}/systemd/60-rubble.rules DESTINATION lib/udev/rules.d COMPONENT rubble)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION share/doc/rubble RENAME copyright COMPONENT rubble)

# dpkg asks before it replaces what the operator changed.
set(conffiles)
foreach(file IN LISTS config_files)
  get_filename_component(name ${file} NAME)
  string(APPEND conffiles "/etc/rubble/${name}\n")
endforeach()
file(WRITE ${PROJECT_BINARY_DIR}/debian/conffiles "${conffiles}")

set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL rubble rubble-dev)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_PACKAGE_NAME rubble)
set(CPACK_PACKAGE_CONTACT "Rubble maintainers <rubble@localhost>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_RUBBLE_PACKAGE_NAME rubble)
set(CPACK_DEBIAN_RUBBLE_DESCRIPTION 
  "Monocular and grid SLAM, their fusion, a recogniser of victims, labels and codes, drivers and a console, as systemd services.")
set(CPACK_DEBIAN_RUBBLE_PACKAGE_SECTION science)
set(CPACK_DEBIAN_RUBBLE_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUBBLE_PACKAGE_DEPENDS "systemd, iproute2")
set(CPACK_DEBIAN_RUBBLE_PACKAGE_RECOMMENDS "udev")
set(CPACK_DEBIAN_RUBBLE_PACKAGE_SUGGESTS "rubble-dev, liblcm-bin")
set(CPACK_DEBIAN_RUBBLE_PACKAGE_CONTROL_EXTRA
  ${PROJECT_BINARY_DIR}/debian/conffiles
  ${PROJECT_SOURCE_DIR}/cmake/debian/postinst
  ${PROJECT_SOURCE_DIR}/cmake/debian/prerm
  ${PROJECT_SOURCE_DIR}/cmake/debian/postrm)
set(CPACK_DEBIAN_RUBBLE_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_RUBBLE-DEV_PACKAGE_NAME rubble-dev)
set(CPACK_DEBIAN_RUBBLE-DEV_DESCRIPTION 
  "The LCM types for other programs, their C++ headers (/usr/include/rubble-lcmtypes) and the Java classes for lcm-spy.")
set(CPACK_DEBIAN_RUBBLE-DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_RUBBLE-DEV_PACKAGE_DEPENDS "liblcm-dev")
set(CPACK_DEBIAN_RUBBLE-DEV_PACKAGE_RECOMMENDS "liblcm-java, default-jre")
include(CPack)
