#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace hapton::dds_test {

// Properties of a discovered writer or reader.
struct FoundTopic {
  std::string type;
  bool is_reliable = false;
  bool is_transient = false;
  bool has_key = false;
};

struct Header {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  std::string frame_id;
  std::int64_t stamp_ns() const { return 1'000'000'000LL * sec + nanosec; }
};

// PoseStamped (position, then quaternion x, y, z, w), TwistStamped (linear, angular) and WrenchStamped (force, torque) are a header and
// numbers.
struct Stamped {
  Header header;
  std::vector<double> numbers;
};
struct Joy {
  Header header;
  std::vector<float> axes;
  std::vector<std::int32_t> buttons;
};
struct Transform {
  Header header;
  std::string child_frame_id;
  std::vector<double> numbers;  // translation, then quaternion x, y, z, w
};

// A participant of another DDS implementation (Fast DDS). It encodes and decodes the CDR bytes itself, so that it shares no code with what
// it tests, not even the IDL. Threads: one, besides those of Fast DDS.
class FastNode {
 public:
  enum class Reach {
    loopback,
    as_ros,  // the default settings, as nodes of ROS 2 have them
  };
  explicit FastNode(int domain, Reach reach = Reach::loopback);
  ~FastNode();
  FastNode(const FastNode&) = delete;
  FastNode& operator=(const FastNode&) = delete;

  // Makes a reader of that DDS topic and type, as a ROS 2 subscription does.
  void subscribe(const std::string& topic, const std::string& type, bool is_reliable = false);
  bool is_matched(const std::string& topic) const;
  // All samples since the last call, oldest first.
  std::vector<std::vector<unsigned char>> take(const std::string& topic);

  static Stamped read_stamped(const std::vector<unsigned char>& bytes, std::size_t numbers);
  static Joy read_joy(const std::vector<unsigned char>& bytes);
  static std::vector<Transform> read_transforms(const std::vector<unsigned char>& bytes);

  // Writes a WrenchStamped with a reliable writer, as a ROS 2 publisher of that DDS topic does. The first call for a topic makes the
  // writer.
  void write_wrench(const std::string& topic, const std::string& frame_id, double fx, double fy, double fz, double tx = 0.0);

  // Writers and readers of other participants, by DDS topic.
  std::map<std::string, FoundTopic> writers() const;
  std::map<std::string, FoundTopic> readers() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace hapton::dds_test
