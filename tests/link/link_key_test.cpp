#include "link/link_key.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "link/key_schedule.h"
#include "link/udp_endpoint.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/open_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

mode_t mode_of(const std::filesystem::path& path) {
  struct stat status = {};
  EXPECT_EQ(stat(path.c_str(), &status), 0) << path;
  return status.st_mode & 07777;
}

class LinkKeyTest : public testing::Test {
 protected:
  LinkKeyTest() { EXPECT_TRUE(seal::start_crypto()); }

  std::filesystem::path write_key(const std::string& name, std::size_t bytes, mode_t mode, const std::string& role = "master") {
    std::string text = "hapton-" + role + std::string(9 - role.size(), '\0') + "a secret of many different bytes";
    text.resize(bytes, 'k');
    const auto path = folder_.write(name, text);
    EXPECT_EQ(chmod(path.c_str(), mode), 0);
    return path;
  }

  static std::string rejection(const std::filesystem::path& path) {
    const auto key = read_key_file(path);
    EXPECT_FALSE(key) << path;
    if (key) return {};
    EXPECT_THAT(key.error().what, HasSubstr(path.string()));
    EXPECT_EQ(key.error().what.find('\n'), std::string::npos);
    return key.error().what;
  }

  ScratchFolder folder_;
};

TEST_F(LinkKeyTest, MakesAFileThatOnlyItsUserCanRead) {
  const auto path = folder_.path() / "key";
  const mode_t old_mask = umask(0);
  const auto made = make_key_file(path);
  umask(old_mask);
  ASSERT_TRUE(made) << made.error().what;
  EXPECT_EQ(mode_of(path), mode_t{0600});
  EXPECT_EQ(std::filesystem::file_size(path), kKeyFileBytes);
  const auto key = read_key_file(path);
  ASSERT_TRUE(key) << key.error().what;
  EXPECT_EQ(key->bytes(), read_key_file(path)->bytes());
}

TEST_F(LinkKeyTest, TwoKeysAreNeverAlike) {
  std::set<LinkKey::Bytes> keys;
  for (int i = 0; i < 100; ++i) keys.insert(LinkKey::make_random().bytes());
  EXPECT_EQ(keys.size(), 100U);
}

TEST_F(LinkKeyTest, LeavesAFileThatIsThereAsItIs) {
  const auto path = folder_.write("key", "something dear");
  const auto made = make_key_file(path);
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().what, HasSubstr("already exists"));
  EXPECT_EQ(std::filesystem::file_size(path), 14U) << "as many bytes as were written above";
  // It does not write through a symbolic link either.
  std::filesystem::create_symlink(folder_.path() / "elsewhere", folder_.path() / "link");
  EXPECT_FALSE(make_key_file(folder_.path() / "link"));
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "elsewhere"));
}

TEST_F(LinkKeyTest, APlaceThatIsNotThereIsAnError) {
  const auto made = make_key_file(folder_.path() / "no" / "such" / "key");
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().what, HasSubstr("No such file"));
}

TEST_F(LinkKeyTest, RejectsAWrongSizeWithTheRemedy) {
  for (const std::size_t bytes : {0U, 1U, 31U, 33U, 47U, 49U, 4096U}) {
    const std::string message = rejection(write_key("key", bytes, 0600));
    EXPECT_THAT(message, HasSubstr(std::to_string(bytes)));
    EXPECT_THAT(message, HasSubstr("hapton keygen"));
  }
}

TEST_F(LinkKeyTest, RejectsAModeThatLetsOthersInWithTheRemedy) {
  for (const mode_t mode : {0644, 0640, 0660, 0666, 0604, 0601, 0777}) {
    EXPECT_THAT(rejection(write_key("key", kKeyFileBytes, mode)), HasSubstr("chmod 600"));
  }
  for (const mode_t mode : {0600, 0400}) EXPECT_TRUE(read_key_file(write_key("key", kKeyFileBytes, mode)));
}

TEST_F(LinkKeyTest, TakesWhatSystemdHandsToAService) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can make a file that is root's";
  // A file of root with an access list for the service's user: the list appears as read permission of root's group.
  const auto path = write_key("key", kKeyFileBytes, 0440);
  ASSERT_EQ(chown(path.c_str(), 0, 0), 0);
  const auto key = read_key_file(path);
  EXPECT_TRUE(key) << key.error().what;
  ASSERT_EQ(chown(path.c_str(), 0, 12345), 0);
  EXPECT_THAT(rejection(path), HasSubstr("chmod 600"));
}

TEST_F(LinkKeyTest, RejectsAnotherUsersFileWithTheRemedy) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can give a file away";
  const auto path = write_key("key", kKeyFileBytes, 0600);
  ASSERT_EQ(chown(path.c_str(), 12345, 12345), 0);
  EXPECT_THAT(rejection(path), HasSubstr("chown"));
}

TEST_F(LinkKeyTest, RejectsWhatIsNoRegularFile) {
  EXPECT_THAT(rejection(folder_.path()), HasSubstr("regular"));
  const auto fifo = folder_.path() / "fifo";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_THAT(rejection(fifo), HasSubstr("regular"));
  EXPECT_THAT(rejection(folder_.path() / "gone"), HasSubstr("hapton keygen"));
}

TEST_F(LinkKeyTest, RejectsAKeyWhoseBytesAreAllTheSame) {
  for (const char byte : {'\0', 'k', '\xff'}) {
    const auto path = folder_.write("key", std::string("hapton-master\0\0\0", 16) + std::string(32, byte));
    ASSERT_EQ(chmod(path.c_str(), 0600), 0);
    EXPECT_THAT(rejection(path), HasSubstr("all bytes of the key are the same"));
  }
}

TEST_F(LinkKeyTest, RejectsAKeyOfAnOlderHaptonAndSaysWhatToDo) {
  const std::string message = rejection(write_key("key", 32, 0600));
  EXPECT_THAT(message, HasSubstr("older Hapton"));
  EXPECT_THAT(message, HasSubstr("hapton keygen --role"));
}

TEST_F(LinkKeyTest, RejectsAFileOfTheRightLengthThatIsNoKey) {
  for (const std::string role : {"io", "Master", "vision2", ""}) {
    EXPECT_THAT(rejection(write_key("key", kKeyFileBytes, 0600, role)), HasSubstr("not a Hapton key file")) << role;
  }
}

TEST_F(LinkKeyTest, RejectsAFolderThatEveryoneMayChange) {
  const auto open_folder = folder_.path() / "open";
  std::filesystem::create_directories(open_folder / "below");
  ASSERT_EQ(chmod(open_folder.c_str(), 0777), 0);
  const auto path = open_folder / "below" / "key";
  const auto not_made = make_key_file(path);
  ASSERT_FALSE(not_made);
  EXPECT_THAT(not_made.error().what, HasSubstr("chmod o-w " + open_folder.string()));
  EXPECT_FALSE(std::filesystem::exists(path));
  // With the sticky bit, as in /tmp, no other user can put another file in its place.
  ASSERT_EQ(chmod(open_folder.c_str(), 01777), 0);
  ASSERT_TRUE(make_key_file(path));
  EXPECT_TRUE(read_key_file(path));
  ASSERT_EQ(chmod(open_folder.c_str(), 0777), 0);
  EXPECT_THAT(rejection(path), HasSubstr("chmod o-w " + open_folder.string()));
  // A symbolic link leads to the same folder, which is checked, too.
  std::filesystem::create_symlink(path, folder_.path() / "link");
  EXPECT_THAT(rejection(folder_.path() / "link"), HasSubstr("chmod o-w"));
  ASSERT_EQ(chmod(open_folder.c_str(), 0755), 0);
  EXPECT_TRUE(read_key_file(path));
  // A link in a folder that everyone may change can be made to lead anywhere.
  const auto good = write_key("good", kKeyFileBytes, 0600);
  std::filesystem::create_symlink(good, open_folder / "way");
  EXPECT_TRUE(read_key_file(open_folder / "way"));
  ASSERT_EQ(chmod(open_folder.c_str(), 0777), 0);
  EXPECT_THAT(rejection(open_folder / "way"), HasSubstr("chmod o-w " + open_folder.string()));
  EXPECT_TRUE(read_key_file(good));
}

TEST_F(LinkKeyTest, ARolesKeyIsGoodForThatRoleAlone) {
  const auto master_path = folder_.path() / "master";
  ASSERT_TRUE(make_key_file(master_path));
  const LinkKey master = *read_key_file(master_path);
  const auto path = folder_.path() / "vision";
  ASSERT_TRUE(make_role_key_file(path, master, KeyRole::vision));
  EXPECT_EQ(mode_of(path), mode_t{0600});
  const auto key = read_role_key_file(path, KeyRole::vision);
  ASSERT_TRUE(key) << key.error().what;
  EXPECT_EQ(key->role(), KeyRole::vision);
  EXPECT_EQ(key->bytes(), read_role_key_file(master_path, KeyRole::vision)->bytes());
  EXPECT_NE(key->bytes(), read_role_key_file(master_path, KeyRole::haptics)->bytes());
  EXPECT_THAT(rejection(path), HasSubstr("the hub needs the master key"));
  for (const KeyRole other : {KeyRole::haptics, KeyRole::tool, KeyRole::operator_role}) {
    const auto rejected = read_role_key_file(path, other);
    ASSERT_FALSE(rejected);
    EXPECT_THAT(rejected.error().what,
                HasSubstr("is the key of role vision, and this needs that of role " + std::string(to_string(other))));
    EXPECT_THAT(rejected.error().what, HasSubstr("hapton keygen --role"));
  }
  EXPECT_FALSE(make_role_key_file(path, master, KeyRole::tool)) << "what is there stays";
}

TEST_F(LinkKeyTest, AnOperatorsKeyIsAToolsToo) {
  const LinkKey master = LinkKey::make_random();
  const auto path = folder_.path() / "operator";
  ASSERT_TRUE(make_role_key_file(path, master, KeyRole::operator_role));
  EXPECT_EQ(read_role_key_file(path, KeyRole::tool)->role(), KeyRole::operator_role);
  const auto tool = folder_.path() / "tool";
  ASSERT_TRUE(make_role_key_file(tool, master, KeyRole::tool));
  EXPECT_FALSE(read_role_key_file(tool, KeyRole::operator_role));
}

TEST_F(LinkKeyTest, NodesThatStartAtOnceShareOneKey) {
  constexpr int kThreads = 8;
  for (int round = 0; round < 20; ++round) {
    const auto folder = folder_.path() / std::to_string(round) / "hapton";
    std::atomic<int> ready = 0;
    std::vector<LinkKey::Bytes> keys(kThreads);
    std::vector<std::thread> threads;
    for (LinkKey::Bytes& bytes : keys) {
      threads.emplace_back([&] {
        ++ready;
        while (ready < kThreads) std::this_thread::yield();
        const auto key = find_or_make_shared_key(folder);
        if (key) bytes = key->bytes();
      });
    }
    for (std::thread& thread : threads) thread.join();
    for (const LinkKey::Bytes& bytes : keys) {
      EXPECT_EQ(bytes, keys.front());
      EXPECT_NE(bytes, LinkKey::Bytes{});
    }
    EXPECT_EQ(mode_of(folder / "master"), mode_t{0600});
    EXPECT_EQ(mode_of(folder), mode_t{0700});
    // No temporary file remains.
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  }
}

TEST_F(LinkKeyTest, ASharedKeyThatIsOpenToOthersIsRejected) {
  const auto folder = folder_.path() / "hapton";
  ASSERT_TRUE(find_or_make_shared_key(folder));
  ASSERT_EQ(chmod((folder / "master").c_str(), 0644), 0);
  EXPECT_FALSE(find_or_make_shared_key(folder));
}

TEST_F(LinkKeyTest, ASharedKeyThatCannotBeMadeIsAnErrorWithTheRemedy) {
  const auto key = find_or_make_shared_key(folder_.write("a_file", "") / "hapton");
  ASSERT_FALSE(key);
  EXPECT_THAT(key.error().what, HasSubstr("--key FILE"));
  EXPECT_EQ(key.error().what.find('\n'), std::string::npos);
}

TEST_F(LinkKeyTest, DistinguishesLoopbackFromOtherAddresses) {
  for (const char* address : {"127.0.0.1:1", "127.255.0.3:1", "[::1]:1"}) EXPECT_TRUE(is_loopback(*parse_address(address))) << address;
  for (const char* address : {"0.0.0.0:1", "[::]:1", "10.0.0.1:1", "128.0.0.1:1", "[::2]:1", "[fe80::1]:1", "126.255.255.255:1"}) {
    EXPECT_FALSE(is_loopback(*parse_address(address))) << address;
  }
}

TEST_F(LinkKeyTest, BeyondLoopbackAFileMustBeNamed) {
  for (const char* address : {"0.0.0.0:4950", "192.168.1.2:4950", "[::]:4950"}) {
    const auto key = find_link_key("", *parse_address(address));
    ASSERT_FALSE(key);
    EXPECT_THAT(key.error().what, HasSubstr(address));
    EXPECT_THAT(key.error().what, HasSubstr("--key"));
  }
  const auto file = write_key("key", kKeyFileBytes, 0600).string();
  EXPECT_TRUE(find_link_key(file, *parse_address("0.0.0.0:4950")));
  EXPECT_EQ(find_role_key(file, *parse_address("10.0.0.1:4950"), KeyRole::tool)->role(), KeyRole::tool);
  EXPECT_FALSE(find_role_key("", *parse_address("10.0.0.1:4950"), KeyRole::tool));
}

// This is one test because it changes the environment of this process.
TEST_F(LinkKeyTest, OnLoopbackTheUsersOwnKeyIsFound) {
  const auto find_variable = [](const char* name) {
    const char* value = std::getenv(name);
    return value == nullptr ? std::optional<std::string>() : std::optional<std::string>(value);
  };
  const auto old_runtime = find_variable("XDG_RUNTIME_DIR");
  const auto old_home = find_variable("HOME");
  const auto runtime = folder_.path() / "run";
  const auto home = folder_.path() / "home";
  const Address loopback = *parse_address("127.0.0.1:4950");

  setenv("XDG_RUNTIME_DIR", runtime.c_str(), 1);
  setenv("HOME", home.c_str(), 1);
  const auto key = find_link_key("", loopback);
  ASSERT_TRUE(key) << key.error().what;
  EXPECT_EQ(key->bytes(), read_key_file(runtime / "hapton" / "master")->bytes());
  EXPECT_EQ(key->bytes(), find_link_key("", loopback)->bytes());
  EXPECT_EQ(RoleKey(*key, KeyRole::haptics).bytes(), find_role_key("", loopback, KeyRole::haptics)->bytes());

  unsetenv("XDG_RUNTIME_DIR");
  const auto home_key = find_link_key("", loopback);
  ASSERT_TRUE(home_key) << home_key.error().what;
  EXPECT_EQ(home_key->bytes(), read_key_file(home / ".config" / "hapton" / "master")->bytes());

  unsetenv("HOME");
  EXPECT_FALSE(find_link_key("", loopback));

  const auto restore = [](const char* name, const std::optional<std::string>& value) {
    value ? setenv(name, value->c_str(), 1) : unsetenv(name);
  };
  restore("XDG_RUNTIME_DIR", old_runtime);
  restore("HOME", old_home);
}

TEST_F(LinkKeyTest, ReadingAKeyLeavesNoFileOpen) {
  const auto good = write_key("good", kKeyFileBytes, 0600);
  const auto open_to_all = write_key("open", kKeyFileBytes, 0644);
  EXPECT_FALSE(leaves_files_open([&] {
    EXPECT_TRUE(read_key_file(good));
    EXPECT_FALSE(read_key_file(open_to_all));
  }));
}

// As on a full disk: an incomplete key would be a key that nobody else has.
TEST_F(LinkKeyTest, AKeyThatCannotBeWrittenWholeIsNotThereAtAll) {
  const auto path = folder_.path() / "master.key";
  for (const rlim_t bytes : {0U, 16U}) {
    const FileSizeLimit full(bytes);
    const auto made = make_key_file(path);
    ASSERT_FALSE(made) << bytes;
    EXPECT_THAT(made.error().what, HasSubstr("master.key: the key cannot be written: "));
    EXPECT_THAT(made.error().what, HasSubstr(bytes == 0U ? "File too large" : "No space left on device"));
    EXPECT_FALSE(std::filesystem::exists(path)) << bytes;
    const auto shared = folder_.path() / "shared";
    EXPECT_THAT(find_or_make_shared_key(shared).error().what, HasSubstr("this user's key cannot be written: "));
    EXPECT_TRUE(std::filesystem::is_empty(shared)) << bytes;
  }
  EXPECT_TRUE(make_key_file(path));
}

}  // namespace
}  // namespace hapton
