# weft_unity(<list>): replaces sources by one file per folder, which includes those of that folder.
#
# For most of our sources the headers of the standard library cost the compiler more than the rest.
# CMake's UNITY_BUILD would batch across folders, leave out sources with options, and write absolute
# paths, by which a compiler cache tells two checkouts apart.
function(weft_unity list_name)
  if(NOT WEFT_UNITY)
    return()
  endif()
  set(result "")
  set(folders "")
  foreach(source IN LISTS ${list_name})
    get_source_file_property(definitions "${source}" COMPILE_DEFINITIONS)
    if(definitions)
      list(APPEND result "${source}")  # its definitions are not for the others
    else()
      cmake_path(GET source PARENT_PATH folder)
      file(RELATIVE_PATH folder "${CMAKE_CURRENT_SOURCE_DIR}" "${folder}")
      file(RELATIVE_PATH include "${CMAKE_SOURCE_DIR}" "${source}")
      list(APPEND folders "${folder}")
      string(APPEND "content_${folder}" "#include \"${include}\"\n")
    endif()
  endforeach()
  list(REMOVE_DUPLICATES folders)
  foreach(folder IN LISTS folders)
    set(unity "${CMAKE_CURRENT_BINARY_DIR}/unity/${folder}.cpp")
    file(CONFIGURE OUTPUT "${unity}" CONTENT "${content_${folder}}")
    list(APPEND result "${unity}")
  endforeach()
  set(${list_name} ${result} PARENT_SCOPE)
endfunction()
