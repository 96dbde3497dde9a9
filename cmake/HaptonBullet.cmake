# Defines the target hapton_bullet, the rigid-body dynamics of Bullet, if Bullet is installed.
include_guard(GLOBAL)
find_package(Bullet QUIET MODULE)
if(BULLET_FOUND)
  # SYSTEM, because its headers do not compile without warnings.
  add_library(hapton_bullet INTERFACE)
  target_include_directories(hapton_bullet SYSTEM INTERFACE ${BULLET_INCLUDE_DIRS})
  target_link_libraries(hapton_bullet INTERFACE ${BULLET_LIBRARIES})
endif()
