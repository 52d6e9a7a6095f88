# Rewrites build_info.cpp if the commit or the state of the checkout has changed since. Run at
# every build (cmake -P), so that a commit recompiles this one file and no other.
#
# -D SOURCE_DIR, INPUT, OUTPUT, WEFT_COMPILER, WEFT_CUDA_VERSION, WEFT_BUILD_TYPE
set(commit unknown)
set(dirty false)
find_program(GIT git)
if(GIT AND EXISTS "${SOURCE_DIR}/.git")
  execute_process(
    COMMAND "${GIT}" -C "${SOURCE_DIR}" rev-parse HEAD
    OUTPUT_VARIABLE head
    RESULT_VARIABLE failed
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(NOT failed)
    set(commit "${head}")
    # Untracked files count: sources are found by pattern. No lock, so that a build never disturbs
    # a git command beside it.
    execute_process(
      COMMAND "${GIT}" --no-optional-locks -C "${SOURCE_DIR}" status --porcelain
      OUTPUT_VARIABLE changes
      ERROR_QUIET)
    if(changes)
      set(dirty true)
    endif()
  endif()
endif()
configure_file("${INPUT}" "${OUTPUT}" @ONLY)  # leaves an unchanged file alone
