# cmake -D ROOM=... -D THREE=... -D ORBIT=... -D NOTICE=... -D OUTPUT=FILE.cpp -P page_bundle.cmake
#
# Makes the page of the player without its data: page.html with page.css, three.js and page.js in
# it. Its policy allows the style and the script by their hashes, and nothing else. Without THREE
# there is no page.
cmake_minimum_required(VERSION 3.25)
set(head "")
set(tail "")

# SHA-256 in base64, as a content security policy has it.
function(policy_hash text result)
  string(SHA256 hex "${text}")
  set(digits "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/")
  set(hash "")
  # 32 bytes are ten groups of three, and two bytes more.
  foreach(group RANGE 10)
    math(EXPR at "6 * ${group}")
    string(SUBSTRING "${hex}0000" ${at} 6 three)
    math(EXPR value "0x${three}")
    foreach(shift IN ITEMS 18 12 6 0)
      math(EXPR digit "(${value} >> ${shift}) & 63")
      string(SUBSTRING "${digits}" ${digit} 1 letter)
      string(APPEND hash "${letter}")
    endforeach()
  endforeach()
  string(SUBSTRING "${hash}" 0 43 hash)
  set(${result} "'sha256-${hash}='" PARENT_SCOPE)
endfunction()

if(THREE)
  foreach(name IN ITEMS html css js)
    file(READ "${ROOM}/page.${name}" ${name})
  endforeach()
  file(READ "${THREE}" three)
  file(READ "${ORBIT}" orbit)
  file(READ "${NOTICE}" notice)
  string(REPLACE "&" "&amp;" notice "${notice}")
  string(REPLACE "<" "&lt;" notice "${notice}")
  set(script "${three}\n${orbit}\n${js}")
  if(script MATCHES "</script")
    message(FATAL_ERROR "${THREE}: the script would end the page's own")
  endif()
  policy_hash("${script}" script_hash)
  policy_hash("${css}" style_hash)
  string(REPLACE "@POLICY@" "default-src 'none'; script-src ${script_hash}; style-src ${style_hash}"
                 html "${html}")
  string(REPLACE "@STYLE@" "${css}" html "${html}")
  string(REPLACE "@NOTICE@" "${notice}" html "${html}")
  string(REPLACE "@SCRIPT@" "${script}" html "${html}")
  string(FIND "${html}" "@DATA@" at)
  string(SUBSTRING "${html}" 0 ${at} head)
  math(EXPR at "${at} + 6")
  string(SUBSTRING "${html}" ${at} -1 tail)
endif()

# Hexadecimal escapes need no care for quotes, backslashes and line ends.
foreach(part IN ITEMS head tail)
  string(HEX "${${part}}" hex)
  string(REGEX REPLACE "(..)" "\\\\x\\1" ${part} "${hex}")
endforeach()
file(WRITE "${OUTPUT}" "#include \"host/app/view/player_page.hpp\"

namespace weft::app {
namespace {

constexpr char head[] = \"${head}\";
constexpr char tail[] = \"${tail}\";

}  // namespace

PageShell built_shell() {
  return {{head, sizeof head - 1}, {tail, sizeof tail - 1}};
}

}  // namespace weft::app
")
