#pragma once

#include <gtest/gtest.h>

#include <string>
#include <variant>
#include <vector>

namespace hapton {

// A numeric option: the smallest and the largest value that it accepts, a value below and one above these, and the field that it sets.
template <class Options>
struct OptionRange {
  const char* flag;
  const char* least;
  const char* most;
  const char* below;
  const char* beyond;
  double (*value)(const Options&);
};

// parse: turns a vector of words into std::variant<Options, int> (an exit code). required: other words that the command needs.
template <class Options, class Parse>
void expect_range(const OptionRange<Options>& range, const Parse& parse, const std::vector<const char*>& required = {}) {
  const auto parse_with = [&](const char* number) {
    std::vector<const char*> words = required;
    words.insert(words.end(), {range.flag, number});
    return parse(words);
  };
  SCOPED_TRACE(range.flag);
  for (const char* number : {range.least, range.most}) {
    const auto parsed = parse_with(number);
    ASSERT_TRUE(std::holds_alternative<Options>(parsed)) << number;
    EXPECT_DOUBLE_EQ(range.value(std::get<Options>(parsed)), std::stod(number));
  }
  for (const char* number : {range.below, range.beyond, "nan", "much"}) {
    const auto parsed = parse_with(number);
    ASSERT_TRUE(std::holds_alternative<int>(parsed)) << number;
    EXPECT_NE(std::get<int>(parsed), 0) << number;
  }
}

}  // namespace hapton
