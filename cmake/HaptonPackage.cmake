# Installs the package that find_package(hapton COMPONENTS core scene link runtime devices safety plugin) finds. Each component has its own export
# file, so a program needs only the dependencies of the components that it names. HaptonInstall.cmake includes this file.
include(CMakePackageConfigHelpers)
set(hapton_cmake_folder ${CMAKE_INSTALL_LIBDIR}/cmake/hapton)
set(hapton_components "")

# hapton_component(NAME FOLDERS ... TARGETS ...): installs the libraries of a component (TARGETS) and the headers in FOLDERS, if all of the libraries
# are built. The last target becomes hapton::NAME.
function(hapton_component name)
  cmake_parse_arguments(ARG "" "" "FOLDERS;TARGETS" ${ARGN})
  foreach(target IN LISTS ARG_TARGETS)
    if(NOT TARGET ${target})
      return()
    endif()
    string(REPLACE "hapton_" "" exported ${target})
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${exported})
  endforeach()
  install(TARGETS ${ARG_TARGETS} EXPORT hapton-${name} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/hapton COMPONENT dev
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libs NAMELINK_COMPONENT dev)
  install(EXPORT hapton-${name} NAMESPACE hapton:: DESTINATION ${hapton_cmake_folder} FILE hapton-${name}.cmake COMPONENT dev)
  foreach(folder IN LISTS ARG_FOLDERS)
    # Without scene/gltf: only the sources of scene itself include those headers.
    install(DIRECTORY ${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/hapton COMPONENT dev
      FILES_MATCHING PATTERN "*.h" PATTERN "gltf" EXCLUDE)
  endforeach()
  set(hapton_components ${hapton_components} ${name} PARENT_SCOPE)
endfunction()

# Libraries and programs may be compiled for different CPUs, but must align Eigen's types in the same way. So programs that use the package get the
# alignment that Eigen chooses for the CPU of the libraries.
set(hapton_cpu "")
if(HAPTON_MARCH)
  set(hapton_cpu "-march=${HAPTON_MARCH}")
endif()
execute_process(COMMAND ${CMAKE_CXX_COMPILER} ${hapton_cpu} -dM -E -x c++ /dev/null OUTPUT_VARIABLE hapton_cpu_macros COMMAND_ERROR_IS_FATAL ANY)
set(hapton_alignment 16)
if(hapton_cpu_macros MATCHES "__AVX512F__")
  set(hapton_alignment 64)
elseif(hapton_cpu_macros MATCHES "__AVX__")
  set(hapton_alignment 32)
endif()
foreach(limit EIGEN_MAX_ALIGN_BYTES EIGEN_MAX_STATIC_ALIGN_BYTES)
  target_compile_definitions(hapton_options INTERFACE "$<INSTALL_INTERFACE:${limit}=${hapton_alignment}>")
endforeach()
# hapton::march, for programs that are to be compiled for the CPU of the libraries.
add_library(hapton_march INTERFACE)
target_compile_options(hapton_march INTERFACE ${hapton_cpu})

add_library(hapton_core INTERFACE)
target_link_libraries(hapton_core INTERFACE hapton_core_force hapton_core_tool)
hapton_component(core FOLDERS core
  TARGETS hapton_options hapton_march hapton_core_base hapton_core_math hapton_core_effects hapton_core_geometry hapton_core_sculpt hapton_core_collision hapton_core_force
          hapton_core_tool hapton_core)
hapton_component(runtime FOLDERS runtime TARGETS hapton_runtime)
hapton_component(link FOLDERS link TARGETS hapton_proto hapton_link)
hapton_component(scene FOLDERS scene TARGETS hapton_scene)
hapton_component(safety FOLDERS safety TARGETS hapton_safety)
hapton_component(devices FOLDERS devices hid watchdog plugin TARGETS hapton_hid hapton_watchdog_library hapton_plugin_host hapton_devices)
# For plug-ins, which need no other component. They can also be built without CMake.
hapton_component(plugin TARGETS hapton_plugin)
install(FILES plugin/hapton_plugin.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/hapton/plugin COMPONENT dev)

# The headers of core include it. It includes only headers of the standard library.
find_file(HAPTON_EXPECTED_HEADER tl/expected.hpp REQUIRED)
install(FILES "${HAPTON_EXPECTED_HEADER}" DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/hapton/tl COMPONENT dev)
install(FILES proto/hapton.proto proto/session.proto DESTINATION ${CMAKE_INSTALL_DATADIR}/hapton/proto COMPONENT dev)
# Without examples/python, which is installed with the Python module.
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DATADIR}/hapton COMPONENT dev PATTERN "python" EXCLUDE)

set(hapton_reads_draco OFF)
if(TARGET hapton_scene)
  get_target_property(hapton_scene_definitions hapton_scene INTERFACE_COMPILE_DEFINITIONS)
  if(hapton_scene_definitions MATCHES "HAPTON_DRACO")
    set(hapton_reads_draco ON)
  endif()
endif()
configure_package_config_file(cmake/hapton-config.cmake.in "${CMAKE_BINARY_DIR}/hapton-config.cmake" INSTALL_DESTINATION ${hapton_cmake_folder})
write_basic_package_version_file("${CMAKE_BINARY_DIR}/hapton-config-version.cmake" VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_BINARY_DIR}/hapton-config.cmake" "${CMAKE_BINARY_DIR}/hapton-config-version.cmake"
  DESTINATION ${hapton_cmake_folder} COMPONENT dev)
