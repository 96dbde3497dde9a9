#include "plugin/plugin_file.h"

#include <dlfcn.h>
#include <elf.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <string_view>

#include "runtime/regular_file.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{256} << 20;
constexpr std::size_t kWhySize = 512;
constexpr double kMaxForceN = 100.0;  // as for every effect of a scene
constexpr double kMaxTorqueNm = 10.0;
constexpr char kHowToCompile[] = "compile the plug-in with: gcc -shared -fPIC -o FILE.so FILE.c";

#if defined(__x86_64__)
constexpr unsigned kMachine = EM_X86_64;
#elif defined(__aarch64__)
constexpr unsigned kMachine = EM_AARCH64;
#else
constexpr unsigned kMachine = EM_NONE;  // another processor: the loader decides
#endif

// The loader maps the segments that the headers announce; if the file is too short for them, the program dies.
bool holds_its_segments(const Elf64_Ehdr& header, std::string_view bytes) {
  if (header.e_phentsize != sizeof(Elf64_Phdr)) return false;
  for (std::size_t n = 0; n < header.e_phnum; ++n) {
    const std::uint64_t at = header.e_phoff + n * sizeof(Elf64_Phdr);
    if (at > bytes.size() || bytes.size() - at < sizeof(Elf64_Phdr)) return false;
    Elf64_Phdr segment;
    std::memcpy(&segment, bytes.data() + at, sizeof segment);
    if (segment.p_offset > bytes.size() || bytes.size() - segment.p_offset < segment.p_filesz) return false;
  }
  return true;
}

Result<void> check_elf(const std::string& path, std::string_view bytes) {
  Elf64_Ehdr header = {};
  if (bytes.size() < EI_NIDENT || bytes.substr(0, SELFMAG) != std::string_view(ELFMAG, SELFMAG))
    return fail("{}: is not a shared library; {}", path, kHowToCompile);
  if (bytes[EI_CLASS] != ELFCLASS64) return fail("{}: is for 32-bit programs; compile it for this machine", path);
  if (bytes[EI_DATA] != ELFDATA2LSB) return fail("{}: is for a processor of another byte order; compile it for this machine", path);
  if (bytes.size() < sizeof header) return fail("{}: is cut short; {}", path, kHowToCompile);
  std::memcpy(&header, bytes.data(), sizeof header);
  if (kMachine != EM_NONE && header.e_machine != kMachine)
    return fail("{}: is for another processor (ELF machine {}, this one is {}); compile it for this machine", path, header.e_machine,
                kMachine);
  if (header.e_type != ET_DYN) return fail("{}: is an object file or a program, not a shared library; {}", path, kHowToCompile);
  if (!holds_its_segments(header, bytes)) return fail("{}: is cut short; {}", path, kHowToCompile);
  return {};
}

std::uint64_t fnv1a(std::string_view bytes, std::uint64_t hash) {
  for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3U;
  return hash;
}

// For a path that it has loaded before, the loader gives that code again, whatever the file holds now. False: the code is of other bytes.
bool is_code_of(const void* handle, std::uint64_t hash_of_bytes) {
  struct Loaded {
    std::mutex mutex;
    std::map<const void*, std::uint64_t> hashes;
  };
  static auto& loaded = *new Loaded;  // never destroyed: threads of StoppableCalls may outlive main()
  const std::scoped_lock lock(loaded.mutex);
  return loaded.hashes.try_emplace(handle, hash_of_bytes).first->second == hash_of_bytes;
}

std::string one_line(std::string_view text) {
  std::string line(text);
  std::ranges::replace_if(
      line, [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

Result<void> check_bounds(const std::string& path, double max_force_n, double max_torque_nm) {
  if (!(max_force_n > 0.0 && max_force_n <= kMaxForceN))
    return fail("{}: its max_force_n is {}; state the largest force it gives, above 0 and at most {} N", path, max_force_n, kMaxForceN);
  if (!(max_torque_nm >= 0.0 && max_torque_nm <= kMaxTorqueNm))
    return fail("{}: its max_torque_nm is {}; state the largest torque it gives, 0 to {} Nm", path, max_torque_nm, kMaxTorqueNm);
  return {};
}

struct Needed {
  const char* name;
  bool is_there;
};
Result<void> check_functions(const std::string& path, const char* symbol, std::initializer_list<Needed> needed) {
  for (const Needed& function : needed) {
    if (!function.is_there) return fail("{}: {} has no {}; give it one (plugin/hapton_plugin.h)", path, symbol, function.name);
  }
  return {};
}

}  // namespace

Result<PluginFile> PluginFile::open(const PluginChoice& choice) {
  PluginFile file(choice);
  std::error_code error;
  // The loader looks up a name without a slash in its own folders.
  if (const auto absolute = std::filesystem::absolute(choice.file, error); !error) file.choice_.file = absolute.lexically_normal().string();
  const auto bytes = read_regular_file(file.path(), "give the shared library of a plug-in (docs/plugins.md)", kMaxBytes);
  if (!bytes) return tl::unexpected(bytes.error());
  if (const auto checked = check_elf(file.path(), *bytes); !checked) return tl::unexpected(checked.error());
  const std::uint64_t hash_of_bytes = fnv1a(*bytes, 0xcbf29ce484222325U);
  file.hash_ = hash_of_bytes;
  for (const auto& [key, value] : choice.parameters) file.hash_ = fnv1a(key + "=" + value + ",", file.hash_);
  // Binds all symbols now: a missing one is reported here instead of ending the program at its first call.
  const bool has_returned = call_plugin([&] { file.handle_ = ::dlopen(file.path().c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE); });
  if (!has_returned) return fail("{}: it threw a C++ exception while it was loaded", file.path());
  if (file.handle_ != nullptr && is_code_of(file.handle_, hash_of_bytes)) return file;
  if (file.handle_ != nullptr) return fail("{}: has changed since it was loaded; start this program again to use it", file.path());
  const char* said = ::dlerror();
  std::string_view reason = said != nullptr ? said : "the loader gives no reason";
  if (reason.starts_with(file.path() + ": ")) reason.remove_prefix(file.path().size() + 2);
  return fail("{}: cannot be loaded: {}; ldd -r {} shows what it needs", file.path(), one_line(reason), file.path());
}

Error PluginFile::explain_missing(const char* symbol) const {
  struct Kind {
    const char* symbol;
    const char* is;
  };
  constexpr std::array kinds = {Kind{"hapton_effect", "an effect: haptics_node --effect FILE"},
                                Kind{"hapton_method", "a method: haptics_node --method FILE"},
                                Kind{"hapton_device", "a device: io_node --device plugin:FILE"}};
  for (const Kind& kind : kinds) {
    if (::dlsym(handle_, kind.symbol) != nullptr) return {fmt::format("{}: exports no {}; it is {}", path(), symbol, kind.is)};
  }
  return {fmt::format("{}: exports no {}; include plugin/hapton_plugin.h and state the plug-in with its macro (docs/plugins.md)", path(),
                      symbol)};
}

// Checks the first words of the constant: the ABI version, its own size, then the sizes of the structures that are exchanged.
Result<const std::uint32_t*> PluginFile::find(const char* symbol, std::initializer_list<std::size_t> sizes) const {
  const auto* words = static_cast<const std::uint32_t*>(::dlsym(handle_, symbol));
  if (words == nullptr) return tl::unexpected(explain_missing(symbol));
  if (words[0] != HAPTON_PLUGIN_ABI) {
    return fail(
        "{}: is compiled for version {} of the plug-in interface, this program has version {}; compile it with the hapton_plugin.h of this "
        "release",
        path(), words[0], HAPTON_PLUGIN_ABI);
  }
  const std::uint32_t* word = words;
  for (const std::size_t size : sizes) {
    if (*++word != size) {
      return fail("{}: its {} has a structure of {} bytes, {} are expected; compile it with the hapton_plugin.h of this release", path(),
                  symbol, *word, size);
    }
  }
  return words;
}

Result<const hapton_effect_api*> PluginFile::find_effect() const {
  const auto words = find("hapton_effect", {sizeof(hapton_effect_api), sizeof(hapton_effect_input), sizeof(hapton_effect_output)});
  if (!words) return tl::unexpected(words.error());
  const auto* api = reinterpret_cast<const hapton_effect_api*>(*words);
  const auto checked = check_functions(path(), "hapton_effect", {{"create", api->create != nullptr}, {"step", api->step != nullptr}});
  if (!checked) return tl::unexpected(checked.error());
  return check_bounds(path(), api->max_force_n, api->max_torque_nm).map([&] { return api; });
}

Result<const hapton_method_api*> PluginFile::find_method() const {
  const auto words =
      find("hapton_method", {sizeof(hapton_method_api), sizeof(hapton_method_input), sizeof(hapton_method_output), sizeof(hapton_object)});
  if (!words) return tl::unexpected(words.error());
  const auto* api = reinterpret_cast<const hapton_method_api*>(*words);
  const auto checked = check_functions(
      path(), "hapton_method", {{"create", api->create != nullptr}, {"reset", api->reset != nullptr}, {"step", api->step != nullptr}});
  if (!checked) return tl::unexpected(checked.error());
  return check_bounds(path(), api->max_force_n, 0.0).map([&] { return api; });
}

Result<const hapton_device_api*> PluginFile::find_device() const {
  const auto words = find("hapton_device", {sizeof(hapton_device_api), sizeof(hapton_device_limits), sizeof(hapton_device_sample)});
  if (!words) return tl::unexpected(words.error());
  const auto* api = reinterpret_cast<const hapton_device_api*>(*words);
  return check_functions(path(), "hapton_device",
                         {{"open", api->open != nullptr},
                          {"read", api->read != nullptr},
                          {"write", api->write != nullptr},
                          {"close", api->close != nullptr}})
      .map([&] { return api; });
}

PluginRequest::PluginRequest(const PluginChoice& choice) : choice_(choice), why_(kWhySize, '\0') {
  for (const auto& [key, value] : choice.parameters) parameters_.push_back({key.c_str(), value.c_str()});
  request_ = {parameters_.data(), parameters_.size(), why_.data(), why_.size()};
}

Error PluginRequest::rejection(const std::string& name) const {
  std::string why = one_line({why_.data(), ::strnlen(why_.data(), why_.size())});
  if (why.empty()) why = "it does not say why";
  std::string given = choice_.to_text();
  return {fmt::format("{}: {} does not start: {}", given, name, why)};
}

std::string clean_plugin_name(const char* name) {
  constexpr std::size_t kLongest = 24;
  std::string clean = name == nullptr ? "" : std::string(name, ::strnlen(name, kLongest));
  std::ranges::replace_if(
      clean, [](unsigned char c) { return std::isalnum(c) == 0 && c != '_' && c != '-' && c != '.'; }, '_');
  return clean.empty() ? "unnamed" : clean;
}

}  // namespace hapton
