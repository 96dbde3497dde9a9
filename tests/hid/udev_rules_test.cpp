// deploy/udev/70-hapton.rules has a rule for each device in the catalogue.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>
#include <vector>

#include "docs/hid/hapton_hid_device.h"
#include "hid/hid_catalog.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

std::vector<std::string> read_rules() {
  std::ifstream file(std::string(HAPTON_SOURCE_DIR) + "/deploy/udev/70-hapton.rules");
  std::vector<std::string> rules;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && line[0] != '#') rules.push_back(line);
  }
  return rules;
}

// "0003:256F:C635.": the name that the kernel gives a USB HID device, without the number at its end.
std::string kernel_name(std::uint16_t vid, std::uint16_t pid) {
  char text[16];
  std::snprintf(text, sizeof text, "0003:%04X:%04X.", vid, pid);
  return text;
}

// Whether a rule names this product, or all products of its vendor ("0003:256F:*").
bool grants(const std::vector<std::string>& rules, std::uint16_t vid, std::uint16_t pid) {
  const std::string name = kernel_name(vid, pid);
  for (const std::string& rule : rules) {
    const bool names_it = rule.find(name + "*") != std::string::npos && pid != 0;
    if (names_it || rule.find(name.substr(0, 10) + "*") != std::string::npos) return true;
  }
  return false;
}

TEST(UdevRules, NameEveryDeviceOfTheCatalogue) {
  const auto rules = read_rules();
  for (const HidCatalogEntry& entry : hid_catalog()) {
    if (entry.vid != 0) {
      EXPECT_TRUE(grants(rules, entry.vid, entry.pid)) << entry.name;
    }
  }
  EXPECT_FALSE(grants(rules, 0x046d, 0xc077)) << "a Logitech mouse is no affair of ours";
}

// udev compares with the text in sysfs: USB ids are in lower case, names of HID devices in upper case.
TEST(UdevRules, WriteIdsAsTheKernelDoes) {
  static const std::regex kWrong(R"re(id(Vendor|Product)\}=="[^"]*[A-F]|000[35]:[^"]*[a-f])re");
  for (const std::string& rule : read_rules()) EXPECT_FALSE(std::regex_search(rule, kWrong)) << rule;
}

// The rules also apply to a device that is plugged in while the package is installed: nobody has to plug it in again.
TEST(UdevRules, AreAppliedByThePackageToEverySubsystemThatTheyName) {
  std::ifstream file(std::string(HAPTON_SOURCE_DIR) + "/deploy/debian/postinst");
  std::stringstream postinst;
  postinst << file.rdbuf();
  static const std::regex kSubsystem(R"re(^SUBSYSTEM[!=]="([a-z]+)")re");
  int named_subsystems = 0;
  for (const std::string& rule : read_rules()) {
    std::smatch found;
    if (!std::regex_search(rule, found, kSubsystem)) continue;
    ++named_subsystems;
    EXPECT_NE(postinst.str().find("--subsystem-match=" + found[1].str() + " "), std::string::npos) << rule;
  }
  EXPECT_GE(named_subsystems, 3);
}

class HaptonHidRule : public ::testing::Test {
 protected:
  // Runs the program that udev would run on this descriptor. True: it recognises a Hapton HID device.
  bool recognises(std::string_view descriptor) {
    static const std::regex kProgram(R"re(PROGRAM=="([^"]*)")re");
    for (const std::string& rule : read_rules()) {
      std::smatch found;
      if (!std::regex_search(rule, found, kProgram)) continue;
      const std::string file = folder_.write("report_descriptor", descriptor).string();
      const std::string command = std::regex_replace(found[1].str(), std::regex("/sys%p/device/report_descriptor"), file);
      return std::system(command.c_str()) == 0;
    }
    ADD_FAILURE() << "there is no such rule";
    return false;
  }
  ScratchFolder folder_;
};

TEST_F(HaptonHidRule, KnowsADeviceByItsReportDescriptor) {
  const std::string_view descriptor(reinterpret_cast<const char*>(hapton_hid_descriptor), sizeof hapton_hid_descriptor);
  EXPECT_TRUE(recognises(descriptor));
  std::string other(descriptor);
  other[1] = 0x47;
  EXPECT_FALSE(recognises(other));
  EXPECT_FALSE(recognises("\x05\x01\x09\x02\xa1\x01"));
  EXPECT_FALSE(recognises(""));
}

}  // namespace
}  // namespace hapton
