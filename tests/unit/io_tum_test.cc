// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <string>

#include "io/tum_list.h"

namespace fransac::io {
namespace {

TEST(TumList, ReadsLinesCommentsAndBlanks) {
  const auto list = parse_tum_list(
      "# depth maps\n#\n\n"
      "1305031453.374112 depth/a.png\n"
      "  1305031453.404816\tdepth/b.png  \r\n"
      "2e9 depth/c.png # remark",
      "depth.txt");
  ASSERT_TRUE(list.ok()) << list.error().message;
  ASSERT_EQ(list->size(), 3U);
  EXPECT_EQ((*list)[0].time_s, 1305031453.374112);
  EXPECT_EQ((*list)[0].timestamp, "1305031453.374112");
  EXPECT_EQ((*list)[0].file, "depth/a.png");
  EXPECT_EQ((*list)[1].file, "depth/b.png");
  EXPECT_EQ((*list)[2].time_s, 2e9);
}

TEST(TumList, SortsByTimeAndKeepsTheOrderOfEqualTimes) {
  const auto list = parse_tum_list("3 c\n1 a\n2 x\n2 y\n", "depth.txt");
  ASSERT_TRUE(list.ok());
  std::string order;
  for (const TumEntry& entry : *list) order += entry.file;
  EXPECT_EQ(order, "axyc");
}

TEST(TumList, AnEmptyListHasNoEntries) {
  for (const char* text : {"", "\n", "# only a comment", " \t\r\n#\n"}) {
    const auto list = parse_tum_list(text, "depth.txt");
    ASSERT_TRUE(list.ok());
    EXPECT_TRUE(list->empty());
  }
}

TEST(TumList, NamesFileAndLineOfAFault) {
  const std::string not_a_pair = "is not \"timestamp filename\"";
  const std::string no_time = "timestamp is not a number of seconds";
  const std::string outside = "file name leads out of the folder";
  const std::pair<std::string, std::string> faults[] = {
      {"1.5", not_a_pair},
      {"1.5 a.png 1.5 b.png", not_a_pair},
      {"a.png 1.5", no_time},
      {"1.5x a.png", no_time},
      {"nan a.png", no_time},
      {"inf a.png", no_time},
      {"-1 a.png", no_time},
      {"1e999 a.png", no_time},
      {"0x10 a.png", no_time},
      {"1.5 ../a.png", outside},
      {"1.5 depth/../../a.png", outside},
      {"1.5 ..", outside},
      {"1.5 /etc/passwd", outside},
      {std::string("1.5 a\0.png", 10), "file name holds a control character"},
  };
  for (const auto& [line, message] : faults) {
    SCOPED_TRACE(line);
    const auto list = parse_tum_list("# comment\n1 good.png\n" + line + "\n2 good.png\n", "folder/depth.txt");
    ASSERT_FALSE(list.ok());
    EXPECT_EQ(list.error().code, ErrorCode::format);
    EXPECT_EQ(list.error().message, "folder/depth.txt:3: " + message);
  }
}

TEST(TumList, DotsInsideANameAreFine) { EXPECT_TRUE(parse_tum_list("1 depth/a..b.png\n2 ./c.png\n3 ...", "depth.txt").ok()); }

TEST(TumAssociations, ReadsPairsInEitherOrder) {
  const auto pairs = parse_tum_associations(
      "# rgb depth\n2.0 rgb/2.png 2.01 depth/2.png\n1.01 depth/1.png 1.0 rgb/1.png\n3 a.png 3.5 b.png\n", "associations.txt");
  ASSERT_TRUE(pairs.ok()) << pairs.error().message;
  ASSERT_EQ(pairs->size(), 3U);
  EXPECT_EQ((*pairs)[0].depth.file, "depth/1.png");
  EXPECT_EQ((*pairs)[0].depth.timestamp, "1.01");
  EXPECT_EQ((*pairs)[0].colour.file, "rgb/1.png");
  EXPECT_EQ((*pairs)[1].depth.file, "depth/2.png");
  EXPECT_EQ((*pairs)[1].colour.time_s, 2.0);
  EXPECT_EQ((*pairs)[2].depth.file, "b.png");
}

TEST(TumAssociations, NamesFileAndLineOfAFault) {
  const std::pair<std::string, std::string> faults[] = {
      {"1 a.png", "is not \"timestamp filename timestamp filename\""},
      {"1 a.png 1", "is not \"timestamp filename timestamp filename\""},
      {"1 a.png 1 b.png 1", "is not \"timestamp filename timestamp filename\""},
      {"1 a.png x b.png", "timestamp is not a number of seconds"},
      {"1 a.png 1 ../b.png", "file name leads out of the folder"},
  };
  for (const auto& [line, message] : faults) {
    const auto pairs = parse_tum_associations("1 a.png 1 b.png\n" + line + "\n", "associations.txt");
    ASSERT_FALSE(pairs.ok()) << line;
    EXPECT_EQ(pairs.error().message, "associations.txt:2: " + message);
  }
}

const char* nearest(const std::vector<TumEntry>& list, double time_s) {
  const TumEntry* entry = nearest_entry(list, time_s);
  return entry != nullptr ? entry->file.c_str() : "none";
}

TEST(TumAssociation, TakesTheNearestWithinTwentyMilliseconds) {
  const auto list = *parse_tum_list("1305031453.000000 a\n1305031453.030000 b\n1305031453.100000 c\n", "rgb.txt");
  EXPECT_STREQ(nearest(list, 1305031453.000000), "a");
  EXPECT_STREQ(nearest(list, 1305031453.014000), "a");
  EXPECT_STREQ(nearest(list, 1305031453.016000), "b");
  EXPECT_STREQ(nearest(list, 1305031453.049999), "b");
  EXPECT_STREQ(nearest(list, 1305031453.050000), "b");  // exactly 20 ms
  EXPECT_STREQ(nearest(list, 1305031453.050003), "none");
  EXPECT_STREQ(nearest(list, 1305031453.079997), "none");
  EXPECT_STREQ(nearest(list, 1305031453.080000), "c");
  EXPECT_STREQ(nearest(list, 1305031452.980000), "a");
  EXPECT_STREQ(nearest(list, 1305031452.979997), "none");
  EXPECT_STREQ(nearest(list, 1305031453.130000), "none");
  EXPECT_STREQ(nearest({}, 1.0), "none");
}

TEST(TumAssociation, TakesTheEarlierOfTwoEquallyNear) {
  const auto list = *parse_tum_list("1.0 a\n1.03125 b\n", "rgb.txt");  // exact in binary
  EXPECT_STREQ(nearest(list, 1.015625), "a");
}

}  // namespace
}  // namespace fransac::io
