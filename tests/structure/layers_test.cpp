// The layer table of docs/architecture.md, as tests over the #include lines of the whole tree.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/structure/source_tree.h"

namespace hapton::structure {
namespace {

const std::vector<std::string> kFolders = {"core",        "runtime", "link",         "hid",         "scene", "bench",
                                           "watchdog",    "devices", "safety",       "closed_loop", "patch", "remote_touch",
                                           "haptic_step", "io_node", "haptics_node", "vision_node", "tools", "python",
                                           "plugin",      "vrpn",    "recording"};

// Which folders, or single headers, a folder's files may include. Its own are always allowed.
const std::map<std::string, std::vector<std::string>> kMayInclude = {
    {"core/base", {}},
    {"core/math", {"core/base"}},
    {"core/effects", {"core/base", "core/math"}},
    {"core/geometry", {"core/base", "core/math"}},
    {"core/collision", {"core/base", "core/math", "core/geometry"}},
    {"core/sculpt", {"core/base", "core/math", "core/geometry"}},
    {"core/force", {"core/base", "core/math", "core/effects", "core/geometry", "core/sculpt", "core/collision"}},
    {"core/tool", {"core/base", "core/math", "core/effects", "core/geometry", "core/collision"}},
    {"runtime", {"core/base", "core/math"}},
    {"link", {"core/base", "core/math", "runtime"}},
    {"recording", {"core/base", "core/math", "runtime", "link"}},
    {"hid", {"core/base", "core/math", "runtime"}},
    {"vrpn", {"core/base", "core/math", "runtime", "link"}},
    {"scene", {"core"}},
    {"bench", {"core", "runtime", "link"}},
    // It measures the frame rate of vision_node's own view beside that of plain VTK.
    {"bench/frames", {"core", "runtime", "scene", "vision_node"}},
    {"watchdog", {"core/base", "runtime"}},
    {"plugin", {"core", "runtime"}},
    {"devices", {"core/base", "core/math", "runtime", "link", "hid", "watchdog", "plugin"}},
    {"safety", {"core/base/button_bit.h", "core/math", "devices/device.h", "link/key_role.h"}},
    {"closed_loop", {"core", "safety", "devices/device.h", "devices/model_a.h", "link/fault_injector.h"}},
    {"patch", {"core", "link", "runtime"}},
    {"remote_touch", {"core", "link", "closed_loop", "patch", "safety", "devices/device.h"}},
    {"haptic_step", {"core", "link", "runtime", "scene", "plugin"}},
    {"io_node", {"core", "runtime", "link", "hid", "vrpn", "watchdog", "devices", "safety", "patch"}},
    {"haptics_node", {"core", "runtime", "link", "scene", "patch", "closed_loop", "haptic_step", "plugin"}},
    {"vision_node", {"core", "runtime", "link", "recording", "hid", "vrpn", "scene"}},
    {"python", {"core", "runtime", "link", "recording", "scene"}},
    {"tools",
     {"core", "runtime", "link", "recording", "hid", "vrpn", "scene", "bench", "haptic_step", "devices", "safety", "closed_loop", "patch",
      "remote_touch", "plugin"}},
};

bool is_under(const std::string& path, const std::string& folder) { return path.rfind(folder + "/", 0) == 0; }

// The row of the table that a file belongs to; empty when it has none.
std::string layer_of(const std::string& path) {
  std::string longest;
  for (const auto& [folder, unused] : kMayInclude) {
    if (is_under(path, folder) && folder.size() > longest.size()) longest = folder;
  }
  return longest;
}

bool may_include(const std::string& from, const std::string& included) {
  const std::string layer = layer_of(from);
  if (layer.empty()) return false;
  if (is_under(included, layer)) return true;
  for (const std::string& folder : kMayInclude.at(layer)) {
    if (included == folder || is_under(included, folder)) return true;
  }
  return false;
}

bool is_generated_by_protobuf(const std::string& include) { return include.ends_with(".pb.h"); }
bool is_socket(const std::string& include) {
  static const std::regex kSocket(
      R"(^(boost/asio.*|asio.*|sys/socket\.h|sys/un\.h|netinet/.*|arpa/inet\.h|netdb\.h|sys/epoll\.h|poll\.h|sys/select\.h)$)");
  return std::regex_match(include, kSocket);
}
bool is_vtk(const std::string& include) { return include.rfind("vtk", 0) == 0; }
// Headers that a pure layer must not include: threads, clocks, files, terminals, logs, the network.
bool is_impure(const std::string& include) {
  static const std::regex kImpure(
      R"(^(thread|mutex|shared_mutex|condition_variable|future|stop_token|semaphore|latch|barrier|chrono|ctime|time\.h|fstream|iostream)"
      R"(|filesystem|cstdio|stdio\.h|print|syncstream|unistd\.h|fcntl\.h|pthread\.h|sys/.*|spdlog/.*|fmt/(ostream|os|chrono|color)\.h)"
      R"(|boost/.*|google/.*|nlohmann/.*|(external/)?toml.*|CLI/.*|hidapi.*)$)");
  return std::regex_match(include, kImpure) || is_socket(include) || is_vtk(include) || is_generated_by_protobuf(include);
}

// Whether an include names a file of a layer, in any spelling: in quotes, in angle brackets, with "..".
bool is_of_the_tree(const Include& include) {
  return include.quoted || !layer_of(std::filesystem::path(include.path).lexically_normal().string()).empty();
}

bool breaks_the_table(const std::string& from, const Include& include) {
  return is_of_the_tree(include) && !is_generated_by_protobuf(include.path) &&
         !may_include(from, std::filesystem::path(include.path).lexically_normal().string());
}

bool is_misspelt(const Include& include) {
  return is_of_the_tree(include) && !is_generated_by_protobuf(include.path) &&
         (!include.quoted || include.path.find("..") != std::string::npos || !exists(include.path));
}

// "file:line includes X" for every include that a predicate finds wrong.
template <class Predicate>
std::vector<std::string> find_wrong(const std::vector<std::string>& folders, Predicate&& is_wrong) {
  std::vector<std::string> wrong;
  for (const std::string& folder : folders) {
    for (const SourceFile& file : read_folder(folder)) {
      for (const Include& include : file.includes) {
        if (is_wrong(file, include)) wrong.push_back(file.path + ":" + std::to_string(include.line) + " includes " + include.path);
      }
    }
  }
  return wrong;
}

template <class Predicate>
std::vector<std::string> find_files(const std::vector<std::string>& folders, Predicate&& is_wrong) {
  std::vector<std::string> wrong;
  for (const std::string& folder : folders) {
    for (const SourceFile& file : read_folder(folder)) {
      if (is_wrong(file)) wrong.push_back(file.path);
    }
  }
  return wrong;
}

std::string file_name(const std::string& path) { return path.substr(path.find_last_of('/') + 1); }
std::string without_extension(const std::string& path) { return path.substr(0, path.find_last_of('.')); }

using ::testing::IsEmpty;

TEST(Layers, EveryIncludeIsAllowedByTheTable) {
  EXPECT_THAT(find_wrong(kFolders, [](const SourceFile& file, const Include& include) { return breaks_the_table(file.path, include); }),
              IsEmpty());
}

// The folder below core/force that a file belongs to; empty for what all methods share.
std::string method_of(const std::string& path) {
  static const std::regex kMethod("^core/force/([^/]+)/.*");
  std::smatch method;
  return std::regex_match(path, method, kMethod) ? method[1].str() : "";
}

// Each method can be read, changed and removed alone. The proxy has its own part for spheres; evaluation compares methods.
bool may_know_method(const std::string& from, const std::string& included) {
  const std::string own = method_of(from);
  const std::string other = method_of(included);
  return own.empty() || other.empty() || own == other || own == "evaluation" || (own == "proxy" && other == "sphere");
}

TEST(Layers, ForceMethodsDoNotIncludeEachOther) {
  EXPECT_THAT(
      find_wrong({"core/force"}, [](const SourceFile& file, const Include& include) { return !may_know_method(file.path, include.path); }),
      IsEmpty());
  EXPECT_FALSE(may_know_method("core/force/reference/a.cpp", "core/force/proxy/b.h")) << "the reference shares no code with the proxy";
}

// If the system cannot start a thread, the program must end with one line, not abort.
TEST(Layers, EveryThreadIsStartedByStartThread) {
  static const std::regex kStartsThread(R"(std::j?thread(\s+\w+)?\s*[({]|vector<std::j?thread> \w+\(|std::async)");
  std::vector<std::string> wrong;
  for (const std::string& folder : kFolders) {
    for (const SourceFile& file : read_folder(folder)) {
      if (file.path != "runtime/start_thread.h" && std::regex_search(file.code, kStartsThread)) wrong.push_back(file.path);
    }
  }
  EXPECT_THAT(wrong, IsEmpty());
}

// A mesh reader that is still at work when the program ends runs on while static objects are destroyed (see StoppableCalls).
TEST(Layers, WhatReadsScenesHasNoStaticObjectsWithADestructor) {
  static const std::regex kStaticWithDestructor(R"(\bstatic\s+const\s+[\w:<>, ]+\s\w+\s*[;={(])");
  EXPECT_TRUE(std::regex_search("  static const toml::table kEmpty;", kStaticWithDestructor));
  EXPECT_FALSE(std::regex_search("  static const auto& none = *new toml::table;", kStaticWithDestructor));
  std::vector<std::string> wrong;
  for (const char* const folder : {"scene", "runtime"}) {
    for (const SourceFile& file : read_folder(folder)) {
      if (std::regex_search(file.code, kStaticWithDestructor)) wrong.push_back(file.path);
    }
  }
  EXPECT_THAT(wrong, IsEmpty());
}

TEST(Layers, EveryFileBelongsToALayer) {
  EXPECT_THAT(find_files(kFolders, [](const SourceFile& file) { return layer_of(file.path).empty(); }), IsEmpty());
}

TEST(Layers, OwnHeadersAreQuotedFromTheRoot) {
  EXPECT_THAT(find_wrong(kFolders, [](const SourceFile&, const Include& include) { return is_misspelt(include); }), IsEmpty());
}

// The table of message kinds is a header that belongs to one codec, so only codecs may include it.
TEST(Layers, OnlyTheCodecsSeeGeneratedProtobufCode) {
  const std::string table = "link/message_kinds.h";
  EXPECT_THAT(find_wrong(kFolders,
                         [&](const SourceFile& file, const Include& include) {
                           const bool is_codec_only = is_generated_by_protobuf(include.path) || include.path == table;
                           return is_codec_only && !file.path.ends_with("codec.cpp") && file.path != table;
                         }),
              IsEmpty());
}

// Two exceptions without network: the notification to systemd uses a local socket, and the watchdog notices by poll() that a process
// has ended or a device was unplugged.
bool may_use_socket(const std::string& file, const std::string& socket) {
  if (file == "runtime/service_notify.cpp") return socket == "sys/socket.h" || socket == "sys/un.h";
  if (file == "watchdog/main.cpp" || file == "watchdog/outer_watchdog.cpp") return socket == "poll.h";
  return is_under(file, "link") && file_name(file).find("endpoint") != std::string::npos;
}

TEST(Layers, OnlyEndpointFilesSeeSockets) {
  EXPECT_THAT(
      find_wrong(kFolders, [](const SourceFile& file,
                              const Include& include) { return is_socket(include.path) && !may_use_socket(file.path, include.path); }),
      IsEmpty());
}

TEST(Layers, OnlyFloat8SeesVectorInstructions) {
  EXPECT_THAT(find_wrong(kFolders,
                         [](const SourceFile& file, const Include& include) {
                           return include.path.ends_with("intrin.h") && file.path != "core/math/float8_avx2.h";
                         }),
              IsEmpty());
}

// A haptics node reads the same scenes, but must not load OpenGL.
TEST(Layers, OnlyVisionAndBenchPeersSeeVtk) {
  EXPECT_THAT(find_wrong(kFolders,
                         [](const SourceFile& file, const Include& include) {
                           return is_vtk(include.path) && !is_under(file.path, "vision_node") && !is_under(file.path, "bench/peers") &&
                                  !is_under(file.path, "bench/frames");
                         }),
              IsEmpty());
}

bool is_openxr(const std::string& include) { return include.rfind("openxr/", 0) == 0; }

// A build without OpenXR, or with a newer VTK, then affects only a few files.
TEST(Layers, OnlyTheHeadsetSeesOpenXrAndItSeesNoVtk) {
  EXPECT_THAT(find_wrong(kFolders,
                         [](const SourceFile& file, const Include& include) {
                           const bool is_headset = is_under(file.path, "vision_node/xr");
                           const bool is_header = file.path == "vision_node/xr/headset.h";
                           return (is_openxr(include.path) && (!is_headset || is_header)) || (is_vtk(include.path) && is_headset);
                         }),
              IsEmpty());
}

// One exception: core/base/large_vector.cpp asks for memory in large pages when a mesh is prepared.
TEST(Core, TouchesNothingOfTheMachine) {
  EXPECT_THAT(find_wrong({"core", "closed_loop", "remote_touch"},
                         [](const SourceFile& file, const Include& include) {
                           return is_impure(include.path) && !(file.path == "core/base/large_vector.cpp" && include.path == "sys/mman.h");
                         }),
              IsEmpty());
}

TEST(Core, PrintsNothing) {
  static const std::regex kPrints(R"(\b(fmt::print|std::cout|std::cerr|std::clog|printf|puts)\b)");
  EXPECT_THAT(
      find_files({"core", "closed_loop", "remote_touch"}, [](const SourceFile& file) { return std::regex_search(file.code, kPrints); }),
      IsEmpty());
}

// fmt::print and std::println throw if the reader of the stream has gone; print_text does not.
TEST(Nodes, PrintWithoutAnException) {
  static const std::regex kThrows(R"(\b(fmt::print|std::println)\b)");
  EXPECT_THAT(
      find_files({"io_node", "haptics_node", "vision_node", "watchdog", "runtime", "link", "devices", "hid", "safety", "haptic_step"},
                 [](const SourceFile& file) { return std::regex_search(file.code, kThrows); }),
      IsEmpty());
}

TEST(Sources, HaveAtMost500Lines) {
  std::vector<std::string> folders = kFolders;
  folders.emplace_back("tests");
  std::vector<std::string> too_long;
  for (const std::string& folder : folders) {
    for (const SourceFile& file : read_folder(folder)) {
      if (std::ranges::count(file.code, '\n') > 500) too_long.push_back(file.path);
    }
  }
  EXPECT_THAT(too_long, IsEmpty());
}

// Two classes with the same name in one program break the one-definition rule, and no linker reports it.
TEST(Sources, NoTwoHeadersDefineAClassOfOneName) {
  static const std::regex kLine(R"(namespace ([\w:]+) \{|(?:class|struct|enum class) (\w+)(?: final)?(?: :[^;]*)?(?: \{)?)");
  std::map<std::string, std::vector<std::string>> headers;  // by namespace and name
  for (const std::string& folder : kFolders) {
    for (const SourceFile& file : read_folder(folder)) {
      if (!file.path.ends_with(".h")) continue;
      std::istringstream lines(file.code);
      std::string name_space;
      for (std::string line; std::getline(lines, line);) {
        std::smatch match;
        if (!std::regex_match(line, match, kLine)) continue;
        if (match[1].matched) name_space = match[1];
        if (match[2].matched) headers[name_space + "::" + match[2].str()].push_back(file.path);
      }
    }
  }
  EXPECT_GT(headers.size(), 500U);
  for (const auto& [name, paths] : headers) EXPECT_THAT(paths, testing::SizeIs(1)) << name;
}

TEST(Sources, ThrowNothingOfOurs) {
  static const std::regex kThrow(R"(\bthrow\b)");
  // The Python bindings report errors by exceptions.
  const auto throws = [](const SourceFile& file) { return !is_under(file.path, "python") && std::regex_search(file.code, kThrow); };
  EXPECT_THAT(find_files(kFolders, throws), IsEmpty());
}

// Files that may read the wall clock, which can be set, and why. Everything else uses CLOCK_MONOTONIC.
const std::map<std::string, std::string> kMayReadTheDate = {
    {"io_node/session_setup.cpp", "a recording contains the day on which it was made"},
    {"link/random_id.cpp", "one more random source, if the system has none"},
    {"io_node/vrpn/vrpn_server.cpp", "VRPN stamps its messages with the time of day"},
    {"tools/dds/dds_bridge.cpp", "ROS 2 stamps its messages with the time of day"},
};

TEST(Clocks, OnlyTheSteadyOneKeepsTime) {
  static const std::regex kWallClock(R"(\b(system_clock|CLOCK_REALTIME|gettimeofday|high_resolution_clock|utc_clock)\b)");
  EXPECT_THAT(
      find_files(kFolders,
                 [](const SourceFile& file) { return std::regex_search(file.code, kWallClock) && !kMayReadTheDate.contains(file.path); }),
      IsEmpty());
}

TEST(Headers, BeginWithPragmaOnce) {
  EXPECT_THAT(
      find_files(kFolders,
                 [](const SourceFile& file) { return file.path.ends_with(".h") && file.code.find("#pragma once") == std::string::npos; }),
      IsEmpty());
}

// Together with the target hapton_headers_alone in CMakeLists.txt, this ensures that every header compiles on its own.
TEST(Headers, ComeFirstInTheSourceOfTheirName) {
  EXPECT_THAT(find_files(kFolders,
                         [](const SourceFile& file) {
                           const std::string header = without_extension(file.path) + ".h";
                           return file.path.ends_with(".cpp") && exists(header) &&
                                  (file.includes.empty() || file.includes.front().path != header);
                         }),
              IsEmpty());
}

// Headers whose contract is tested elsewhere, each with the reason.
const std::map<std::string, std::string> kTestedElsewhere = {
    {"core/effects/effect_sample.h", "plain data"},
    {"core/force/force_method.h", "an interface and plain settings: each method has its own test"},
    {"core/force/carried_proxy.h", "what deforming_method and streamed_method share: each has its own test"},
    {"core/force/touch_scene.h", "plain data"},
    {"core/geometry/shaded_mesh.h", "plain data: corner_normals and split_large fill it"},
    {"core/geometry/triangle_mesh.h", "plain data"},
    {"core/sculpt/sculpt_settings.h", "plain data: sculpt_reader fills it"},
    {"core/tool/box_lanes.h", "what obb_front and separating_planes share: each has its own test"},
    {"core/math/float8_avx2.h", "tested by float8_test against its scalar twin"},
    {"core/math/float8_scalar.h", "tested by float8_test against AVX2"},
    {"core/math/types.h", "names for Eigen's types"},
};

TEST(Headers, OfTheCoreHaveATestOfTheirName) {
  std::vector<std::string> untested;
  for (const SourceFile& file : read_folder("core")) {
    const bool has_test = exists("tests/" + without_extension(file.path) + "_test.cpp");
    if (file.path.ends_with(".h") && !has_test && !kTestedElsewhere.contains(file.path)) untested.push_back(file.path);
  }
  EXPECT_THAT(untested, IsEmpty());
}

TEST(Headers, ListedAsTestedElsewhereAreThereAndHaveNoTestOfTheirName) {
  for (const auto& [path, reason] : kTestedElsewhere) {
    EXPECT_TRUE(exists(path)) << path;
    EXPECT_FALSE(exists("tests/" + without_extension(path) + "_test.cpp")) << path;
  }
}

// Tests of the checks: each must find a violation.
TEST(Checks, FindWhatIsWrong) {
  EXPECT_FALSE(may_include("core/math/a.h", "core/force/b.h"));
  EXPECT_FALSE(may_include("io_node/main.cpp", "haptics_node/step.h"));
  EXPECT_FALSE(may_include("io_node/main.cpp", "scene/scene.h"));
  EXPECT_FALSE(may_include("runtime/clock.h", "core/geometry/triangle_mesh.h"));
  EXPECT_FALSE(may_include("unknown/a.h", "core/base/result.h"));
  EXPECT_TRUE(may_include("safety/a.h", "devices/device.h"));
  EXPECT_FALSE(may_include("safety/a.h", "devices/hid_device.h"));
  EXPECT_FALSE(may_include("devices/a.h", "safety/b.h"));
  EXPECT_TRUE(may_include("core/force/a.h", "core/math/types.h"));
  EXPECT_TRUE(is_impure("thread"));
  EXPECT_TRUE(is_impure("sys/mman.h"));
  EXPECT_TRUE(is_impure("boost/asio.hpp"));
  EXPECT_FALSE(is_impure("vector"));
  EXPECT_FALSE(is_impure("fmt/core.h"));
  EXPECT_GT(read_folder("core").size(), 5U);
}

TEST(Checks, SeeAnIncludeHoweverItIsWritten) {
  const SourceFile file =
      read_source("haptics_node/main.cpp",
                  "#include \"io_node/network_loop.h\"\n#include <io_node/network_loop.h>\n  #  include  <core/../io_node/network_loop.h>\n"
                  "#include <core/math/types.h>\n#include \"core/math/types.h\"\n#include <vector>\n");
  ASSERT_EQ(file.includes.size(), 6U);
  const auto count = [&](auto&& is_wrong) { return std::ranges::count_if(file.includes, is_wrong); };
  EXPECT_EQ(count([&](const Include& include) { return breaks_the_table(file.path, include); }), 3);
  EXPECT_EQ(count([](const Include& include) { return is_misspelt(include); }), 3) << "all but the first and the last two";
  EXPECT_TRUE(breaks_the_table("io_node/main.cpp", {"./haptics_node/haptics_step.h", true, 1}));
  EXPECT_FALSE(is_misspelt(file.includes[4]));
}

TEST(Checks, ReadCodeWithoutCommentsAndLiterals) {
  const SourceFile file =
      read_source("a.h",
                  "#include \"b/c.h\"\n#include <d>\n// throw\n/* throw */ auto s = \"throw\\\"\"; int n = 1'000; f();\n"
                  "auto r = R\"x(throw)x\"; g();\n");
  ASSERT_EQ(file.includes.size(), 2U);
  EXPECT_EQ(file.includes[0].path, "b/c.h");
  EXPECT_TRUE(file.includes[0].quoted);
  EXPECT_EQ(file.includes[1].path, "d");
  EXPECT_FALSE(file.includes[1].quoted);
  EXPECT_EQ(file.code.find("throw"), std::string::npos) << file.code;
  EXPECT_NE(file.code.find("f();"), std::string::npos) << file.code;
  EXPECT_NE(file.code.find("g();"), std::string::npos) << file.code;
}

}  // namespace
}  // namespace hapton::structure
