# Writes HEADER with the commit that SOURCE_DIR is at, if that is another one than HEADER tells:
#   cmake -DSOURCE_DIR=... -DHEADER=... -P write_commit.cmake
# The environment variable CURVD_COMMIT tells it to builds of a copy without .git, as that of a container image.
set(commit "$ENV{CURVD_COMMIT}")
# Not a clone that SOURCE_DIR merely lies in.
if(commit STREQUAL "" AND EXISTS ${SOURCE_DIR}/.git)
  find_program(GIT git)
  if(GIT)
    execute_process(COMMAND ${GIT} --no-optional-locks -C ${SOURCE_DIR} describe --always --dirty --abbrev=12 --match=v[0-9]*
      OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  endif()
endif()
if(commit STREQUAL "" AND EXISTS ${SOURCE_DIR}/.git)
  set(text "commit unknown")
elseif(commit STREQUAL "")
  set(text "not built in a git clone")
elseif(commit MATCHES "^[A-Za-z0-9._+-]+$")
  set(text "commit ${commit}")
else()
  message(FATAL_ERROR "CURVD_COMMIT: \"${commit}\" must be letters, digits and . _ + -")
endif()
file(CONFIGURE OUTPUT ${HEADER} CONTENT [[
// Written by about/write_commit.cmake.
#pragma once

inline constexpr char kCommit[] = "@text@";
]] @ONLY)
