#include "host/app/run/json_archive.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/app/run/report_fields.hpp"

namespace weft::app {

struct Inner {
  double length = 1;
};
struct Outer {
  int count = 2;
  double share = 0.5;
  double seconds = 0.25;
  FallbackLevel level = FallbackLevel::rigid;
  Vec3<double> place{1, 2, 3};
  std::optional<double> maybe{};
  std::optional<Inner> inner{};
  double seldom = 4;
};

static void fields(JsonArchive& io, Inner& inner) {
  io("length", inner.length);
}
static void fields(JsonArchive& io, Outer& outer) {
  io("count", outer.count);
  io("share", outer.share);
  io.ms("ms", outer.seconds);
  io("level", outer.level);
  io("place", outer.place);
  io("maybe", outer.maybe);
  io("inner", outer.inner);
  io.only_if(outer.seldom > 4, "seldom", outer.seldom);
  io.if_known(outer.count > 2, "known", outer.seldom);
}

TEST(JsonArchive, AreWrittenInTheirOrder) {
  EXPECT_EQ(json_of(Outer{}).dump(),
            R"({"count":2,"share":0.5,"ms":250.0,"level":"rigid","place":[1.0,2.0,3.0],)"
            R"("known":null})");
}

TEST(JsonArchive, AreReadAsTheyWereWritten) {
  Outer outer;
  outer.count = 5;
  outer.share = std::nan("");
  outer.level = FallbackLevel::truncated;
  outer.maybe = 7;
  outer.inner = Inner{8};
  outer.seldom = 9;
  const Outer read = read_fields<Outer>(Json::parse(json_of(outer).dump()), {"count"});
  EXPECT_EQ(read.count, 5);
  EXPECT_TRUE(std::isnan(read.share));
  EXPECT_EQ(read.seconds, 0.25);
  EXPECT_EQ(read.level, FallbackLevel::truncated);
  EXPECT_EQ(read.place, (Vec3<double>{1, 2, 3}));
  EXPECT_EQ(read.maybe, 7);
  ASSERT_TRUE(read.inner);
  EXPECT_EQ(read.inner->length, 8);
  EXPECT_EQ(read.seldom, 9);
}

TEST(JsonArchive, KeepTheirValuesWhereTheFileLacksThem) {
  const Outer read = read_fields<Outer>(Json::parse(R"({"count": 1})"), {"count"});
  EXPECT_EQ(read.count, 1);
  EXPECT_EQ(read.seconds, 0.25);
  EXPECT_FALSE(read.inner);
}

TEST(JsonArchive, RefuseWhatIsSomethingElse) {
  for (const char* text : {R"({})", R"([])", R"({"count": "one"})", R"({"count": 1, "level": "x"})",
                           R"({"count": 1, "level": "unknown"})", R"({"count": 1, "place": [1]})",
                           R"({"count": 1, "share": "y"})"})
    EXPECT_THROW(read_fields<Outer>(Json::parse(text), {"count"}), Json::exception) << text;
}

}  // namespace weft::app
