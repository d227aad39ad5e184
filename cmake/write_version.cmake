# Writes a header with the version and the commit of the sources as they are when the build runs, not
# as they were when it was configured: cmake -DOUTPUT=... -DTEMPLATE=... -DSOURCE=... -DGIT=...
# -DPROJECT_VERSION=... -P write_version.cmake. The header is only touched where it changes.
set(LIPOID_GIT_COMMIT "unknown")
if(GIT)
  execute_process(
    COMMAND "${GIT}" -C "${SOURCE}" describe --always --dirty --abbrev=12
    OUTPUT_VARIABLE described OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(described)
    set(LIPOID_GIT_COMMIT "${described}")
  endif()
endif()
configure_file("${TEMPLATE}" "${OUTPUT}" @ONLY)
