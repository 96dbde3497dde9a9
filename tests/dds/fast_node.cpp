#include "tests/dds/fast_node.h"

#include <fastcdr/Cdr.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/types/TypesBase.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>

#include <cstring>
#include <mutex>
#include <stdexcept>

namespace hapton::dds_test {
namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using Bytes = std::vector<unsigned char>;

constexpr std::uint32_t kMaxBytes = 4096;

// A type whose samples are serialised bytes, including the encapsulation header.
class BytesType : public fast::TopicDataType {
 public:
  explicit BytesType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = kMaxBytes;
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<const Bytes*>(data);
    if (bytes.size() > payload->max_size) return false;
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    payload->encapsulation = CDR_LE;
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    static_cast<Bytes*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<const Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

template <class Info>
FoundTopic describe_topic(const Info& info) {
  return {.type = info.typeName().c_str(),
          .is_reliable = info.m_qos.m_reliability.kind == fast::RELIABLE_RELIABILITY_QOS,
          .is_transient = info.m_qos.m_durability.kind != fast::VOLATILE_DURABILITY_QOS,
          .has_key = info.topicKind() == rtps::WITH_KEY};
}

class Discoveries : public fast::DomainParticipantListener {
 public:
  void on_publisher_discovery(fast::DomainParticipant* self, rtps::WriterDiscoveryInfo&& info) override {
    if (info.info.guid().guidPrefix == self->guid().guidPrefix) return;
    const std::scoped_lock lock(mutex);
    writers[info.info.topicName().c_str()] = describe_topic(info.info);
  }
  void on_subscriber_discovery(fast::DomainParticipant* self, rtps::ReaderDiscoveryInfo&& info) override {
    if (info.info.guid().guidPrefix == self->guid().guidPrefix) return;
    const std::scoped_lock lock(mutex);
    readers[info.info.topicName().c_str()] = describe_topic(info.info);
  }
  std::mutex mutex;
  std::map<std::string, FoundTopic> writers;
  std::map<std::string, FoundTopic> readers;
};

struct Reading {
  explicit Reading(const Bytes& bytes)
      : copy(bytes), buffer(reinterpret_cast<char*>(copy.data()), copy.size()), cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR) {
    cdr.read_encapsulation();
  }
  Header header() {
    Header header;
    cdr >> header.sec >> header.nanosec >> header.frame_id;
    return header;
  }
  std::vector<double> numbers(std::size_t count) {
    std::vector<double> all(count);
    for (double& number : all) cdr >> number;
    return all;
  }
  Bytes copy;
  FastBuffer buffer;
  Cdr cdr;
};

}  // namespace

struct FastNode::State {
  Discoveries discoveries;
  fast::DomainParticipant* participant = nullptr;
  fast::Subscriber* subscriber = nullptr;
  fast::Publisher* publisher = nullptr;
  std::map<std::string, fast::Topic*> topics;
  std::map<std::string, fast::DataReader*> readers;
  std::map<std::string, fast::DataWriter*> writers;

  fast::Topic* topic(const std::string& name, const std::string& type) {
    if (const auto known = topics.find(name); known != topics.end()) return known->second;
    fast::TypeSupport(new BytesType(type)).register_type(participant);
    fast::Topic* made = participant->create_topic(name, type, fast::TOPIC_QOS_DEFAULT);
    if (made == nullptr) throw std::runtime_error("no topic " + name);
    return topics[name] = made;
  }
};

FastNode::FastNode(int domain, Reach reach) : state_(std::make_unique<State>()) {
  fast::DomainParticipantQos qos = fast::PARTICIPANT_QOS_DEFAULT;
  if (reach == Reach::loopback) {
    auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList.emplace_back("127.0.0.1");
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(udp);
    rtps::Locator_t peer;
    rtps::IPLocator::setIPv4(peer, "127.0.0.1");
    qos.wire_protocol().builtin.initialPeersList.push_back(peer);
  }
  state_->participant = fast::DomainParticipantFactory::get_instance()->create_participant(static_cast<fast::DomainId_t>(domain), qos,
                                                                                           &state_->discoveries, fast::StatusMask::none());
  if (state_->participant == nullptr) throw std::runtime_error("no participant of Fast DDS");
  state_->subscriber = state_->participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
  state_->publisher = state_->participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT);
}

FastNode::~FastNode() {
  state_->participant->set_listener(nullptr);
  state_->participant->delete_contained_entities();
  fast::DomainParticipantFactory::get_instance()->delete_participant(state_->participant);
}

void FastNode::subscribe(const std::string& topic, const std::string& type, bool is_reliable) {
  fast::DataReaderQos qos = fast::DATAREADER_QOS_DEFAULT;
  qos.reliability().kind = is_reliable ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = fast::VOLATILE_DURABILITY_QOS;
  qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 1000;
  qos.resource_limits().max_samples_per_instance = 1000;
  fast::DataReader* reader = state_->subscriber->create_datareader(state_->topic(topic, type), qos);
  if (reader == nullptr) throw std::runtime_error("no reader of " + topic);
  state_->readers[topic] = reader;
}

bool FastNode::is_matched(const std::string& topic) const {
  fast::SubscriptionMatchedStatus status;
  state_->readers.at(topic)->get_subscription_matched_status(status);
  return status.current_count > 0;
}

std::vector<Bytes> FastNode::take(const std::string& topic) {
  std::vector<Bytes> all;
  Bytes bytes;
  fast::SampleInfo info;
  while (state_->readers.at(topic)->take_next_sample(&bytes, &info) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
    if (info.valid_data) all.push_back(bytes);
  }
  return all;
}

Stamped FastNode::read_stamped(const Bytes& bytes, std::size_t numbers) {
  Reading reading(bytes);
  Stamped stamped;
  stamped.header = reading.header();
  stamped.numbers = reading.numbers(numbers);
  return stamped;
}

Joy FastNode::read_joy(const Bytes& bytes) {
  Reading reading(bytes);
  Joy joy;
  joy.header = reading.header();
  reading.cdr >> joy.axes >> joy.buttons;
  return joy;
}

std::vector<Transform> FastNode::read_transforms(const Bytes& bytes) {
  Reading reading(bytes);
  std::uint32_t count = 0;
  reading.cdr >> count;
  std::vector<Transform> all(count);
  for (Transform& one : all) {
    one.header = reading.header();
    reading.cdr >> one.child_frame_id;
    one.numbers = reading.numbers(7);
  }
  return all;
}

void FastNode::write_wrench(const std::string& topic, const std::string& frame_id, double fx, double fy, double fz, double tx) {
  fast::DataWriter*& writer = state_->writers[topic];
  if (writer == nullptr) {
    fast::DataWriterQos qos = fast::DATAWRITER_QOS_DEFAULT;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = fast::VOLATILE_DURABILITY_QOS;
    writer = state_->publisher->create_datawriter(state_->topic(topic, "geometry_msgs::msg::dds_::WrenchStamped_"), qos);
    if (writer == nullptr) throw std::runtime_error("no writer of " + topic);
  }
  Bytes bytes(kMaxBytes);
  FastBuffer buffer(reinterpret_cast<char*>(bytes.data()), bytes.size());
  Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
  cdr.serialize_encapsulation();
  cdr << std::int32_t{1} << std::uint32_t{2} << frame_id << fx << fy << fz << tx << 0.0 << 0.0;
  bytes.resize(cdr.getSerializedDataLength());
  writer->write(&bytes);
}

std::map<std::string, FoundTopic> FastNode::writers() const {
  const std::scoped_lock lock(state_->discoveries.mutex);
  return state_->discoveries.writers;
}
std::map<std::string, FoundTopic> FastNode::readers() const {
  const std::scoped_lock lock(state_->discoveries.mutex);
  return state_->discoveries.readers;
}

}  // namespace hapton::dds_test
