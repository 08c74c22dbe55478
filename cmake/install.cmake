# What `cmake --install` puts where: the programs, the C++ client for find_package and pkg-config, and the contract.
# Nothing of it depends on where the sources or the prefix lie, so that the tree may be moved. See docs/cpp.md.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS curvd DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT curvd)
install(TARGETS curv DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT curv)

# Archives only: a shared library would promise that its binary interface stays, which a 0.x release cannot. Position
# independent nevertheless, so that a user's plug-in or Python extension can hold them.
set(client_archives curv_client curv_protocol curvd_bulk_message curvd_http_date curvd_proto curvd_result_columns)
set_target_properties(${client_archives} PROPERTIES POSITION_INDEPENDENT_CODE ON)
foreach(archive IN LISTS client_archives)
  string(REGEX REPLACE "^curvd?_" "" name ${archive})
  set_target_properties(${archive} PROPERTIES EXPORT_NAME ${name})
endforeach()
# Headers lie in a folder of their own, since a "client/" among all others' headers says nothing.
set(header_dir ${CMAKE_INSTALL_INCLUDEDIR}/curvd)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/curvd)
install(TARGETS ${client_archives} EXPORT curvd_client
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
  FILE_SET HEADERS DESTINATION ${header_dir} COMPONENT dev)
install(EXPORT curvd_client NAMESPACE curv:: FILE curvdTargets.cmake DESTINATION ${package_dir} COMPONENT dev)
configure_package_config_file(cmake/curvdConfig.cmake.in ${PROJECT_BINARY_DIR}/package/curvdConfig.cmake
  INSTALL_DESTINATION ${package_dir} NO_SET_AND_CHECK_MACRO)
# Before 1.0.0 a minor version may break what the one before it promised.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/package/curvdConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/package/curvdConfig.cmake ${PROJECT_BINARY_DIR}/package/curvdConfigVersion.cmake
  DESTINATION ${package_dir} COMPONENT dev)

# The prefix as seen from where the file lies, so that it may be moved.
file(RELATIVE_PATH CURVD_PREFIX_FROM_PKGCONFIG /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
configure_file(cmake/curvd-client.pc.in ${PROJECT_BINARY_DIR}/package/curvd-client.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/package/curvd-client.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)

foreach(proto curvature/v1/curvature.proto google/rpc/error_details.proto google/rpc/status.proto)
  get_filename_component(folder ${proto} DIRECTORY)
  install(FILES proto/${proto} DESTINATION ${CMAKE_INSTALL_DATADIR}/curvd/proto/${folder} COMPONENT dev)
endforeach()
