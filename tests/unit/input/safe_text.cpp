#include "host/input/safe_text.hpp"

#include <gtest/gtest.h>

#include <string>

#include "host/io/mesh/mesh_formats.hpp"

namespace weft::io {
namespace {

TEST(SafeText, OneLineKeepsWhatATerminalShows) {
  EXPECT_EQ(one_line("a name_1-2.x (№ 3), Hülle 布 👕"), "a name_1-2.x (№ 3), Hülle 布 👕");
  EXPECT_EQ(one_line("a\nb\rc\td"), "a?b?c?d");
  EXPECT_EQ(one_line(std::string_view("a\0b", 3)), "a?b");
  EXPECT_EQ(one_line("\x1b[31mred\x7f"), "?[31mred?");
  EXPECT_EQ(one_line("\xc2\x9b"
                     "31m"),
            "?31m");  // a control character of two bytes
  EXPECT_EQ(one_line("a\u2028b\u202ec\u200bd\ufeff"), "a?b?c?d?");
  // Cut off, too long for what it says, a surrogate, beyond Unicode.
  EXPECT_EQ(one_line("\xc3"), "?");
  EXPECT_EQ(one_line("\xc0\x8a"), "??");
  EXPECT_EQ(one_line("\xed\xa0\x80"), "???");
  EXPECT_EQ(one_line("\xf4\x90\x80\x80"), "????");
  EXPECT_EQ(one_line("\xff\xfe"), "??");
}

TEST(SafeText, FileNamesStayInTheirFolder) {
  for (const char* name : {"drape", "my scene-2_b.v1", "Hülle", "布"})
    EXPECT_EQ(safe_file_name(name), name);
  EXPECT_EQ(safe_file_name("../../x"), "_._.._x");
  EXPECT_EQ(safe_file_name("/etc/passwd"), "_etc_passwd");
  EXPECT_EQ(safe_file_name("a\\b"), "a_b");
  EXPECT_EQ(safe_file_name("."), "_");
  EXPECT_EQ(safe_file_name(".."), "_.");
  EXPECT_EQ(safe_file_name(""), "_");
  EXPECT_EQ(safe_file_name("-rf"), "_rf");
  EXPECT_EQ(safe_file_name(".bashrc"), "_bashrc");
  EXPECT_EQ(safe_file_name("a\nb\x1b$(c)`d`'\"*?~"), "a_b___c__d______");
  EXPECT_EQ(safe_file_name(std::string_view("a\0b", 3)), "a_b");
  EXPECT_EQ(safe_file_name("a\u202eb\u2215c\uff0fd"), "a_b_c_d");
  EXPECT_EQ(safe_file_name("\xff"), "_");
  EXPECT_EQ(safe_file_name(std::string(5000, 'x')), std::string(100, 'x'));
  // No character is cut.
  std::string long_name = "x";
  for (int k = 0; k < 100; ++k) long_name += "ü";
  EXPECT_EQ(safe_file_name(long_name), long_name.substr(0, 99));
}

TEST(SafeText, GnuplotTextIsOneQuotedWord) {
  EXPECT_EQ(gnuplot_text("'a'b"), "'\u2019a\u2019b'");
  EXPECT_EQ(gnuplot_text("a\n!touch x"), "'a?!touch x'");
}

TEST(SafeText, CsvTextIsNoFormula) {
  EXPECT_EQ(csv_text("a \"b\", c"), "\"a \"\"b\"\", c\"");
  for (const char* text : {"=1+1", "+1", "-1", "@x", " =1", "=cmd|' /C calc'!A0"})
    EXPECT_EQ(csv_text(text), "\"'" + std::string(text) + "\"");
  EXPECT_EQ(csv_text("\t=1\r\n"), "\"?=1??\"");
}

TEST(SafeText, ScriptJsonHasNoTags) {
  EXPECT_EQ(script_json(R"({"a": "</script><!--"})"), R"({"a": "\u003c/script>\u003c!--"})");
}

TEST(SafeText, ObjNamesStayOnTheirLine) {
  EXPECT_EQ(obj_name("a\nv 0 0 0"), "a?v 0 0 0");
  EXPECT_EQ(obj_name("a\\"), "a_");
  const Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}, {Tri{{0, 1, 2}}}, {}, {}, {}};
  const std::string text = format_obj({{"a\nf 1 1 1\\", mesh}});
  EXPECT_TRUE(text.starts_with("o a?f 1 1 1_\nv ")) << text;
}

TEST(SafeText, ObjGroupsAreReadAsOneLine) {
  const Mesh mesh =
      parse_obj("o a\x1b[2J\xff\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a.obj", Uv::ignore);
  EXPECT_EQ(mesh.group_names, std::vector<std::string>{"a?[2J?"});
}

TEST(SafeText, TheStartOfATextIsQuotedInPrintableCharacters) {
  EXPECT_EQ(quoted_start("a\x1b[2J\xff b~"), "\"a?[2J? b~\"");
  EXPECT_EQ(quoted_start(std::string(100, 'x')), "\"" + std::string(60, 'x') + "\"");
  EXPECT_EQ(quoted_start("abc", 2), "\"ab\"");
  EXPECT_EQ(quoted_start(""), "\"\"");
}

TEST(SafeText, ControlCharactersAloneAreTakenOut) {
  EXPECT_EQ(without_controls("a\n\x7f\xc3\xa9~"), "a??\xc3\xa9~");
  EXPECT_FALSE(is_control(' '));
  EXPECT_FALSE(is_control('\xff'));
}

TEST(SafeText, UsdTextEndsWhereItsQuotationMarkIs) {
  EXPECT_EQ(usd_text("a\"\\\nb"), "\"a\\\"\\\\?b\"");
}

}  // namespace
}  // namespace weft::io
