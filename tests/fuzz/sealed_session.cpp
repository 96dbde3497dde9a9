#include "tests/fuzz/sealed_session.h"

#include <algorithm>
#include <array>

#include "link/noise.h"
#include "tests/fuzz/fixed_random.h"
#include "tests/fuzz/proto_mutator.h"

namespace hapton::fuzz {
namespace {

using namespace seal;

constexpr std::uint32_t kSequenceField = 4;  // of an Envelope: a receiver finds duplicates by it

// A datagram, and its decrypted content; none if its seal is not valid.
struct Item {
  ListedDatagram datagram;
  std::optional<OpenedData> data;
};

noise::Key key_of(const ListedDatagram& datagram) {
  const ChannelKeys keys = session_keys_of(datagram.node());
  return datagram.is_to_node() ? keys.hub_to_client : keys.client_to_hub;
}

std::vector<Item> open_all(std::span<const std::uint8_t> input) {
  FixedRandom::install();
  std::vector<Item> items;
  for (ListedDatagram& datagram : split_datagrams(input)) {
    auto data = open_data(datagram);
    items.push_back({std::move(datagram), std::move(data)});
  }
  return items;
}

Bytes seal_all(std::vector<Item>& items) {
  std::vector<ListedDatagram> datagrams;
  for (Item& item : items) {
    if (item.data) item.datagram.bytes = seal_data(*item.data, item.datagram);
    datagrams.push_back(std::move(item.datagram));
  }
  return join_datagrams(datagrams);
}

// Gives every datagram a new number, so that no receiver takes one for a repetition of another.
void renumber(std::vector<Item>& items, bool has_new_sequences) {
  std::uint64_t counter = 0;
  for (Item& item : items) {
    ++counter;
    if (!item.data) continue;
    item.data->counter = counter;
    auto fields = split_proto(item.data->payload);
    if (!has_new_sequences || !fields) continue;
    for (ProtoField& field : *fields) {
      if (field.number == kSequenceField && field.type == ProtoField::Type::fixed64) field.value = counter;
    }
    item.data->payload = join_proto(*fields);
  }
}

void change_header(Item& item, Mutation& mutation) {
  switch (mutation.below(4)) {
    case 0:
      item.data->connection = static_cast<std::uint32_t>(mutation.odd_number());
      return;
    case 1:
      item.data->counter = mutation.odd_number();
      return;
    default:  // sent in another session, in the other direction, or later
      item.datagram.flags ^= static_cast<std::uint8_t>(1U << mutation.below(5));
      item.data->connection = connection_of(item.datagram.node());
  }
}

}  // namespace

std::uint32_t connection_of(std::uint8_t node) { return 1U + node; }

ChannelKeys session_keys_of(std::uint8_t node) {
  ChannelKeys keys;
  keys.client_to_hub.fill(static_cast<std::uint8_t>(1 + node));
  keys.hub_to_client.fill(static_cast<std::uint8_t>(0x81 + node));
  return keys;
}

SealedChannel make_channel(std::uint8_t node, SealedChannel::Side side) { return {session_keys_of(node), connection_of(node), side}; }

std::optional<OpenedData> open_data(const ListedDatagram& datagram) {
  const SealedKind kind = classify_sealed(as_datagram(datagram.bytes));
  if (kind.status != OpenStatus::opened || kind.kind != Kind::data) return std::nullopt;
  const std::span<const std::uint8_t> all(datagram.bytes);
  OpenedData data{.connection = load<std::uint32_t>(all.data() + kConnectionAt),
                  .counter = load<std::uint64_t>(all.data() + kCounterAt),
                  .payload = Bytes(all.size() - kOverheadBytes)};
  if (!noise::decrypt(key_of(datagram), data.counter, all.first(kHeaderBytes), all.subspan(kHeaderBytes), data.payload.data())) {
    return std::nullopt;
  }
  return data;
}

Bytes seal_data(const OpenedData& data, const ListedDatagram& route) {
  Bytes sealed(data.payload.size() + kOverheadBytes);
  write_lead(Kind::data, sealed.data());
  store(data.connection, sealed.data() + kConnectionAt);
  store(data.counter, sealed.data() + kCounterAt);
  noise::encrypt(key_of(route), data.counter, std::span(sealed).first(kHeaderBytes), data.payload, sealed.data() + kHeaderBytes);
  return sealed;
}

Bytes mutate_sealed(std::span<const std::uint8_t> input, Mutation& mutation) {
  std::vector<Item> items = open_all(input);
  if (mutation.one_in(2)) std::erase_if(items, [](const Item& item) { return !item.data; });
  if (items.empty()) items.push_back({{}, OpenedData{.connection = connection_of(0), .counter = 1, .payload = {0x08}}});
  Item& item = items[mutation.below(items.size())];
  if (!item.data) item.data = OpenedData{.connection = connection_of(item.datagram.node()), .counter = 1, .payload = item.datagram.bytes};
  const std::size_t kind = mutation.below(8);
  if (kind == 0) {
    mutation.change_order(items);
  } else if (kind == 1) {
    renumber(items, false);
    change_header(item, mutation);
    return seal_all(items);
  } else {
    item.data->payload = mutate_proto(item.data->payload, mutation);
    item.data->payload.resize(std::clamp<std::size_t>(item.data->payload.size(), 1, kMaxPayloadBytes));
  }
  renumber(items, mutation.one_in(2));
  return seal_all(items);
}

Bytes cross_sealed(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b, Mutation& mutation) {
  std::vector<Item> items = mutation.cross(open_all(a), open_all(b));
  renumber(items, mutation.one_in(2));
  return seal_all(items);
}

}  // namespace hapton::fuzz
