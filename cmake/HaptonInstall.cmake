# Which files do `cmake --install` and the Debian packages install, and where? There are four parts: `hapton` (programs, scenes, systemd units),
# `vision` (vision_node, the only program that needs VTK), `dev` (the libraries as a CMake package) and `python` (the module of `import hapton`).
# With BUILD_SHARED_LIBS there is a fifth, `libs` (the shared libraries), which all others need.
include(GNUInstallDirs)

# --- programs: each with a manual page and a bash completion, which are generated from its --help ---

function(hapton_install_program program component)
  if(NOT TARGET ${program})
    return()
  endif()
  install(TARGETS ${program} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${component})
  install(CODE "
    execute_process(
      COMMAND \"${CMAKE_SOURCE_DIR}/deploy/man-page\" \"$<TARGET_FILE:${program}>\" ${program} ${PROJECT_VERSION}
              \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_MANDIR}/man1\"
      COMMAND_ERROR_IS_FATAL ANY)" COMPONENT ${component})
  # Needs no completion: only io_node starts it, no person.
  if(program STREQUAL hapton_watchdog)
    return()
  endif()
  install(CODE "
    execute_process(
      COMMAND \"${CMAKE_SOURCE_DIR}/deploy/completion\" \"$<TARGET_FILE:${program}>\" ${program}
              \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/bash-completion/completions\"
      COMMAND_ERROR_IS_FATAL ANY)" COMPONENT ${component})
endfunction()
hapton_install_program(io_node hapton)
hapton_install_program(hapton_watchdog hapton)
hapton_install_program(haptics_node hapton)
hapton_install_program(hapton hapton)
hapton_install_program(vision_node vision)

# --- what the programs need: scenes, configurations, systemd units, rights ---

# Packages (prefix /usr) have their configurations in /etc. With any other prefix all files stay below the prefix.
set(hapton_etc ${CMAKE_INSTALL_SYSCONFDIR})
if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  set(hapton_etc /etc)
endif()
install(DIRECTORY scenes meshes DESTINATION ${CMAKE_INSTALL_DATADIR}/hapton COMPONENT hapton)
install(FILES README.md LICENSE NOTICE-third-party.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT hapton)
install(DIRECTORY docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs COMPONENT hapton)
install(FILES deploy/etc/io.toml deploy/etc/haptics.toml deploy/etc/devices.toml DESTINATION ${hapton_etc}/hapton COMPONENT hapton)
install(FILES deploy/etc/vision.toml DESTINATION ${hapton_etc}/hapton COMPONENT vision)
# The menu entry starts the tour, which needs vision_node.
install(FILES deploy/desktop/hapton.desktop DESTINATION ${CMAKE_INSTALL_DATADIR}/applications COMPONENT vision)
install(FILES deploy/desktop/hapton.svg DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps COMPONENT vision)
install(FILES deploy/systemd/hapton-io.service deploy/systemd/hapton-haptics.service DESTINATION lib/systemd/system COMPONENT hapton)
install(FILES deploy/systemd/hapton-vision.service DESTINATION lib/systemd/user COMPONENT vision)
install(FILES deploy/systemd/hapton.sysusers DESTINATION lib/sysusers.d RENAME hapton.conf COMPONENT hapton)
install(FILES deploy/udev/60-hapton.rules deploy/udev/70-hapton.rules DESTINATION lib/udev/rules.d COMPONENT hapton)
install(FILES deploy/etc/limits.conf DESTINATION ${hapton_etc}/security/limits.d RENAME hapton.conf COMPONENT hapton)

# --- find_package(hapton) ---

include(HaptonPackage)

# --- .deb ---

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME hapton)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "Hapton <hapton@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "touch what you see: force feedback and stereo in three nodes over UDP")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_HAPTON_PACKAGE_NAME hapton)
set(CPACK_COMPONENT_HAPTON_DESCRIPTION "io_node, haptics_node and the hapton command, with scenes, configurations for three hosts and systemd units.")
set(CPACK_DEBIAN_HAPTON_PACKAGE_SUGGESTS "gnuplot-nox")
set(CPACK_DEBIAN_HAPTON_PACKAGE_CONTROL_EXTRA
  "${CMAKE_SOURCE_DIR}/deploy/debian/conffiles;${CMAKE_SOURCE_DIR}/deploy/debian/postinst;${CMAKE_SOURCE_DIR}/deploy/debian/prerm;${CMAKE_SOURCE_DIR}/deploy/debian/postrm")
set(CPACK_DEBIAN_VISION_PACKAGE_NAME hapton-vision)
set(CPACK_COMPONENT_VISION_DESCRIPTION "vision_node: the scene and the probe in stereo; a menu entry that starts the tour.")
set(CPACK_DEBIAN_VISION_PACKAGE_DEPENDS "hapton (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_VISION_PACKAGE_CONTROL_EXTRA "${CMAKE_SOURCE_DIR}/deploy/debian/vision/conffiles")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libhapton-dev)
set(CPACK_COMPONENT_DEV_DESCRIPTION "Hapton's libraries for programs of your own: find_package(hapton COMPONENTS core).")
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
# Required: what the component core needs. Recommended: what the other components need as well.
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libeigen3-dev, libfmt-dev, libmeshoptimizer-dev")
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS
  "libcli11-dev, libspdlog-dev, libtomlplusplus-dev, libprotobuf-dev, libsodium-dev, libpng-dev, libjpeg-dev, libdraco-dev, libtinyxml2-dev, libhidapi-dev, pkg-config")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-hapton)
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "import hapton: forces on NumPy arrays, recordings, a running session, a haptics node in Python.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.11), python3 (<< 3.12), python3-numpy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA "${CMAKE_SOURCE_DIR}/deploy/debian/python/prerm")
set(CPACK_COMPONENTS_ALL hapton dev)
if(BUILD_SHARED_LIBS)
  set(hapton_libs libhapton${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  list(APPEND CPACK_COMPONENTS_ALL libs)
  set(CPACK_DEBIAN_LIBS_PACKAGE_NAME ${hapton_libs})
  set(CPACK_DEBIAN_LIBS_PACKAGE_SECTION libs)
  set(CPACK_COMPONENT_LIBS_DESCRIPTION "Hapton's shared libraries, which its programs and those built against libhapton-dev load.")
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${CMAKE_BINARY_DIR}/lib")
  # Puts the package of the shared libraries before the other dependencies of each package.
  foreach(part HAPTON DEV PYTHON)
    set(CPACK_DEBIAN_${part}_PACKAGE_DEPENDS "${hapton_libs} (= ${PROJECT_VERSION}), ${CPACK_DEBIAN_${part}_PACKAGE_DEPENDS}")
    string(REGEX REPLACE ", $" "" CPACK_DEBIAN_${part}_PACKAGE_DEPENDS "${CPACK_DEBIAN_${part}_PACKAGE_DEPENDS}")
  endforeach()
endif()
if(TARGET hapton_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
if(TARGET vision_node)
  list(APPEND CPACK_COMPONENTS_ALL vision)
endif()
include(CPack)
