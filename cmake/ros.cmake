# The package as ROS sees it: messages, the catkin package, what is installed.
set(TACTILE_CLAY_ROS_COMPONENTS
  roscpp nodelet pluginlib rosbag_storage message_generation
  std_msgs std_srvs geometry_msgs sensor_msgs visualization_msgs
  diagnostic_updater dynamic_reconfigure tf2 tf2_ros tf2_eigen urdf)
# catkin would install setup.bash and its like into the prefix that it was configured with. Here they go wherever
# `cmake --install --prefix` says: they find each other beside themselves.
if(CMAKE_SOURCE_DIR STREQUAL PROJECT_SOURCE_DIR AND NOT DEFINED CATKIN_INSTALL_INTO_PREFIX_ROOT
   AND NOT CATKIN_BUILD_BINARY_PACKAGE AND NOT CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  set(CATKIN_INSTALL_INTO_PREFIX_ROOT FALSE)
  set(TACTILE_CLAY_INSTALLS_ENVIRONMENT TRUE)
endif()
find_package(catkin REQUIRED COMPONENTS ${TACTILE_CLAY_ROS_COMPONENTS})
find_package(topic_tools REQUIRED)  # messages of any type, for few targets
if(TACTILE_CLAY_INSTALLS_ENVIRONMENT)
  # catkin makes these files.
  #catkin_lint: ignore MISSING_FILE
  set(generated ${CMAKE_BINARY_DIR}/catkin_generated/installspace)
  install(PROGRAMS ${CATKIN_DEVEL_PREFIX}/_setup_util.py ${generated}/env.sh DESTINATION .
    COMPONENT environment)
  foreach(shell bash sh zsh)
    install(FILES ${generated}/setup.${shell} ${generated}/local_setup.${shell} DESTINATION .
      COMPONENT environment)
  endforeach()
  #catkin_lint: report MISSING_FILE
  install(CODE "file(WRITE \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/.catkin\" \"\")"  # a workspace
    COMPONENT environment)
endif()

# What catkin_lint takes for errors, and is meant: several packages have no catkin config on Debian, and are found by
# their libraries; the headers for plugins include nothing of ROS, so that who uses them needs none of these packages;
# they are exported from the devel space, which an install replaces; urdfdom is liburdfdom-dev in package.xml; rviz is
# found in its own room alone.
#catkin_lint: ignore UNCONFIGURED_BUILD_DEPEND MISSING_CATKIN_DEPEND EXTERNAL_INCLUDE_PATH
#catkin_lint: ignore MISSING_DEPEND ORDER_VIOLATION SHADOWED_FIND

# Several of these packages come without a catkin config on Debian, so the ones below are named one by one.
set(CMAKE_INCLUDE_CURRENT_DIR OFF)

add_message_files(DIRECTORY msg FILES
  AcousticReport.msg ArrayDrive.msg ArrayState.msg ClayStatus.msg FocalPoint.msg FocalPointArray.msg
  ParameterChange.msg RenderingReport.msg RigLatency.msg RigNumbers.msg TrackedHand.msg TrackedHands.msg)
add_service_files(DIRECTORY srv FILES SculptureFile.srv Undo.srv)
generate_messages(DEPENDENCIES std_msgs geometry_msgs)

# Interfaces for plugins of other packages. In the devel space they are copied to where an install puts them, so
# that `#include <tactile_clay/hand/hand_source.h>` is right in both.
set(TACTILE_CLAY_PUBLIC_HEADERS
  hand/hand_source.h hand/tracked_hand.h device/array_device.h ultrasound/acoustic_field.h ultrasound/acoustics.h
  ultrasound/array_layout.h ultrasound/field_solver.h ultrasound/focal_point.h ultrasound/modulation.h
  ultrasound/phase_solver.h)
foreach(header ${TACTILE_CLAY_PUBLIC_HEADERS})
  get_filename_component(room ${header} DIRECTORY)
  configure_file(src/${header} ${CATKIN_DEVEL_PREFIX}/include/tactile_clay/${header} COPYONLY)
  install(FILES src/${header} DESTINATION include/tactile_clay/${room})
endforeach()

catkin_package(
  INCLUDE_DIRS ${CATKIN_DEVEL_PREFIX}/include
  CATKIN_DEPENDS message_runtime std_msgs geometry_msgs
  DEPENDS EIGEN3
  CFG_EXTRAS tactile_clay-extras.cmake)

# ROS without rviz, as one target; its headers are not ours to warn about.
add_library(tactile_clay_ros INTERFACE)
target_include_directories(tactile_clay_ros SYSTEM INTERFACE ${CATKIN_DEVEL_PREFIX}/include ${catkin_INCLUDE_DIRS})
target_link_libraries(tactile_clay_ros INTERFACE ${catkin_LIBRARIES})
add_dependencies(tactile_clay_ros ${PROJECT_NAME}_generate_messages_cpp)

# Libraries stand beside each other in the devel and the install space; plugins are found with no LD_LIBRARY_PATH.
set(CMAKE_INSTALL_RPATH "$ORIGIN;$ORIGIN/../../lib")

# tactile_clay_install(TARGET...): libraries to lib/, programs to lib/tactile_clay/ where rosrun looks.
function(tactile_clay_install)
  install(TARGETS ${ARGN}
    LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
    RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
endfunction()

# Where the development space lies in the checkout, rosrun finds a script there and in scripts/, and asks which one is
# meant. So those in scripts/ are not executable; catkin makes executable what it installs.
catkin_install_python(PROGRAMS scripts/calibrate_board scripts/describe_rig scripts/fuzz_topics scripts/replay
  scripts/plot_accuracy scripts/rig_view scripts/show_moment scripts/staircase scripts/start_when_set scripts/trial
  DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
# Modules of theirs, which stand beside them and are no programs.
install(FILES scripts/fuzz_messages.py scripts/quest.py scripts/replay_bag.py scripts/replay_compare.py
  scripts/replay_rig.py scripts/rig_files.py scripts/rig_tools.py scripts/trial_link.py scripts/trial_plan.py
  scripts/trial_session.py scripts/trial_staircase.py scripts/trial_summary.py scripts/trial_yaml.py
  DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
install(FILES plugins.xml DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
# rviz asks for a package media_export. Where there is none, whoever sources setup.bash has an empty one.
find_package(media_export QUIET)
if(NOT media_export_FOUND)
  configure_file(rviz/packages/media_export/package.xml
    ${CATKIN_DEVEL_PREFIX}/share/${PROJECT_NAME}/rviz/packages/media_export/package.xml COPYONLY)
  catkin_add_env_hooks(50.tactile_clay SHELLS sh DIRECTORY ${PROJECT_SOURCE_DIR}/cmake/env_hooks)
endif()
install(DIRECTORY launch config rviz DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
install(DIRECTORY test/bags DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION}/test OPTIONAL)
