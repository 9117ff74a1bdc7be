// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/printable.hpp"

#include <gtest/gtest.h>

#include <string>

namespace fransac {
namespace {

TEST(Printable, LeavesWhatCanBePrinted) {
  for (const char* const text : {"", "scans/cloud 1.ply",
                                 "k\xc3\xbc"
                                 "che/\xe6\xb7\xb1.png",
                                 "\xf0\x9f\xa4\x96"})
    EXPECT_EQ(printable(text), text);
}

TEST(Printable, WritesControlCharactersAsNumbers) {
  EXPECT_EQ(printable("a\nb\r\t\x1b[31m\x7f"), "a\\x0ab\\x0d\\x09\\x1b[31m\\x7f");
  EXPECT_EQ(printable("\xc2\x9b"), "\\xc2\\x9b");           // an escape code in one character
  EXPECT_EQ(printable("\xe2\x80\xae"), "\\xe2\\x80\\xae");  // turns the direction of text
  EXPECT_EQ(printable("\xe2\x80\xa8"), "\\xe2\\x80\\xa8");  // ends a line
  EXPECT_EQ(printable(std::string(1, '\0')), "\\x00");
}

TEST(Printable, WritesWhatIsNoUtf8AsNumbers) {
  EXPECT_EQ(printable("\xff"), "\\xff");
  EXPECT_EQ(printable("\xc3"), "\\xc3");
  EXPECT_EQ(printable("\xc0\xaf"), "\\xc0\\xaf");  // '/' in two bytes
  EXPECT_EQ(printable("\xe0\x80\xaf"), "\\xe0\\x80\\xaf");
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");  // a surrogate
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
}

TEST(Printable, LeavesOutTheMiddleOfALongText) {
  EXPECT_EQ(printable("0123456789abcdef", 16), "0123456789abcdef");
  EXPECT_EQ(printable("0123456789abcdefg", 16),
            "0123456789ab\xe2\x80\xa6"
            "defg");
  EXPECT_EQ(printable("0123456789a\xc3\xbc"
                      "bcdefgh",
                      16),
            "0123456789a\xe2\x80\xa6"
            "efgh");  // no half characters
  EXPECT_LT(printable(std::string(5000000, '\n')).size(), 5000U);
  EXPECT_EQ(quoted_text("a'b"), "'a'b'");
  EXPECT_LT(quoted_text(std::string(5000000, 'x')).size(), 60U);
}

}  // namespace
}  // namespace fransac
