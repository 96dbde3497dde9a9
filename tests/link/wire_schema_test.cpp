#include "link/wire_schema.h"

#include <gtest/gtest.h>

#include <string>

namespace hapton {
namespace {

// tests/python/mcap_test.py reads whole messages with this schema.
TEST(WireSchema, NamesTheMessagesOfBothFiles) {
  for (const char* word : {"hapton.proto", "session.proto", "hapton.wire", "hapton.session", "ForceCommand", "force_n", "Cycle", "Event"})
    EXPECT_NE(wire_schema().find(word), std::string_view::npos) << word;
}

}  // namespace
}  // namespace hapton
