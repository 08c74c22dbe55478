// What the points of a cloud are to an estimate: which of them get a result, where it goes, and by what number each is
// known in a larger cloud that this one may be a part of.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/base/scratch_array.h"

namespace curvd {

enum class PointRole : uint8_t {
  kQuery,  // gets a result
  kHalo,   // is a neighbor of others, and gets no result
};

// Points are added in the order of their input, and are known by their place in it until Rank is called; from then on
// by their rank, which is their place in the order of their ids and decides between equal distances. Where ids ascend,
// both are the same, and Rank does nothing. Where all points are queries, and nobody gave ids, id and slot are the
// rank, and no memory is taken.
//
// Thread-compatible: const methods may run concurrently. What adds points may throw std::bad_alloc, and has then added
// none.
class PointSet {
 public:
  PointSet() = default;
  PointSet(PointSet&&) noexcept = default;
  PointSet& operator=(PointSet&&) noexcept = default;

  // Whether the point gets a result.
  bool is_query(int32_t rank) const { return !has_roles_ || slots_[rank] >= 0; }
  // What the random strategies draw by: the point's id in the whole cloud.
  uint64_t seed_of(int32_t rank) const { return has_ids_ ? ids_[rank] : static_cast<uint64_t>(rank); }
  // Where the point's result goes: its place among the queries, in the order of their input. REQUIRES: is_query(rank).
  size_t slot_of(int32_t rank) const { return has_roles_ ? static_cast<size_t>(slots_[rank]) : place_of(rank); }
  // The place of the point in the order of the input.
  size_t place_of(int32_t rank) const { return static_cast<size_t>(is_reordered_ ? places_[rank] : rank); }

  // Fetches what is_query and slot_of read, for soon: neighbors lie anywhere in the order of ids.
  void Prefetch(int32_t rank) const {
    if (has_roles_) {
      __builtin_prefetch(&slots_[rank]);
    } else if (is_reordered_) {
      __builtin_prefetch(&places_[rank]);
    }
  }

  // Points added, and those of them that get a result.
  size_t size() const { return size_; }
  size_t query_count() const { return query_count_; }
  // Whether a point may be something else than a query.
  bool has_roles() const { return has_roles_; }
  bool has_ids() const { return has_ids_; }
  // Whether Rank gave the points another order than that of their input.
  bool is_reordered() const { return is_reordered_; }
  // Bytes held.
  size_t bytes() const { return ids_.bytes() + slots_.bytes() + places_.bytes(); }
  // Bytes that it holds at most for each point, with ids or roles, from when the points are ranked.
  static constexpr size_t BytesPerPoint(bool has_ids, bool has_roles) {
    return (has_ids ? ScratchArray<uint64_t>::MostBytes(2) / 2 + sizeof(int32_t) : 0) +
           (has_roles ? ScratchArray<int32_t>::MostBytes(2) / 2 : 0);
  }

  // Adds `count` queries whose ids are their places.
  void AddQueries(size_t count) {
    MakeRoom(size_ + count);
    if (has_ids_ || has_roles_) {
      for (size_t i = 0; i < count; ++i) Add(size_, PointRole::kQuery);
      return;
    }
    size_ += count;
    query_count_ += count;
  }

  // Adds `count` points. Where `ids` is empty, their ids are their places; where `roles` is empty, all are queries.
  // REQUIRES: either holds `count` entries, or none.
  void AddPart(size_t count, std::span<const uint64_t> ids, std::span<const PointRole> roles) {
    bool are_places = true, are_queries = true;
    for (size_t i = 0; i < ids.size(); ++i) are_places &= ids[i] == size_ + i;
    for (const PointRole role : roles) are_queries &= role == PointRole::kQuery;
    if (!has_ids_ && !are_places) NoteIds();
    if (!has_roles_ && !are_queries) NoteRoles();
    MakeRoom(size_ + count);
    for (size_t i = 0; i < count; ++i) {
      Add(ids.empty() ? size_ : ids[i], roles.empty() ? PointRole::kQuery : roles[i]);
    }
  }

  // Adds a point.
  void Add(uint64_t id, PointRole role) {
    if (!has_ids_ && id != size_) NoteIds();
    if (!has_roles_ && role != PointRole::kQuery) NoteRoles();
    if (has_ids_) {
      ids_.Reserve(size_ + 1);
      ids_[size_] = id;
    }
    if (has_roles_) {
      slots_.Reserve(size_ + 1);
      slots_[size_] = role == PointRole::kQuery ? static_cast<int32_t>(query_count_) : kNoSlot;
    }
    ++size_;
    query_count_ += role == PointRole::kQuery ? 1 : 0;
  }

  // Two places of points that have the same id.
  struct Twins {
    size_t first, second;
    uint64_t id;
  };

  // Orders the points by their ids. Returns two that have the same id, if there are any; what it holds is then
  // undefined. Takes some 20 ns a point where ids do not ascend, and 24 bytes a point meanwhile. May throw
  // std::bad_alloc. REQUIRES: called once, after all points were added.
  std::optional<Twins> Rank();

  // Forgets the points from place `size` on. REQUIRES: size <= size(); Rank was not called.
  void Truncate(size_t size) {
    for (; has_roles_ && size_ > size; --size_) query_count_ -= slots_[size_ - 1] == kNoSlot ? 0 : 1;
    query_count_ -= size_ - size;
    size_ = size;
  }

 private:
  static constexpr int32_t kNoSlot = -1;

  void MakeRoom(size_t size) {
    if (has_ids_) ids_.Reserve(size);
    if (has_roles_) slots_.Reserve(size);
  }

  // Writes down what went without saying.
  void NoteIds() {
    ids_.Reserve(size_ + 1);
    for (size_t i = 0; i < size_; ++i) ids_[i] = i;
    has_ids_ = true;
  }
  void NoteRoles() {
    slots_.Reserve(size_ + 1);
    for (size_t i = 0; i < size_; ++i) slots_[i] = static_cast<int32_t>(i);
    has_roles_ = true;
  }

  size_t size_ = 0;
  size_t query_count_ = 0;
  bool has_ids_ = false;
  bool has_roles_ = false;
  bool is_reordered_ = false;
  ScratchArray<uint64_t> ids_;    // by rank
  ScratchArray<int32_t> slots_;   // by rank; kNoSlot for halo
  ScratchArray<int32_t> places_;  // by rank, once they are not the ranks
};

}  // namespace curvd
