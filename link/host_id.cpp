#include "link/host_id.h"

#include <unistd.h>

#include <array>
#include <fstream>
#include <string>

#include "link/random_id.h"

namespace hapton {
namespace {

// FNV-1a. The result is sent only after it was hashed with a key (handshake.cpp), so this hash need not hide its text.
std::uint64_t hash(const std::string& text) {
  std::uint64_t value = 0xCBF29CE484222325U;
  for (const char c : text) value = (value ^ static_cast<unsigned char>(c)) * 0x100000001B3U;
  return value;
}

// For example "time:[4026531834]"; empty before Linux 5.6.
std::string time_namespace() {
  std::array<char, 64> name = {};
  const ssize_t size = readlink("/proc/self/ns/time", name.data(), name.size());
  return size > 0 ? std::string(name.data(), static_cast<std::size_t>(size)) : std::string();
}

}  // namespace

std::uint64_t find_host_id() {
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string boot;
  if (!std::getline(file, boot) || boot.empty()) return make_random_id();
  return hash(boot + time_namespace());
}

}  // namespace hapton
