#pragma once

#include <algorithm>
#include <mutex>
#include <utility>
#include <vector>

namespace weft {

/// Cards that slices take by turns: each the one that has fewest slices, so that no two slices
/// share a card while another one is free. Which card a slice gets changes none of its bits.
class CardPool {
 public:
  CardPool() = default;
  /// @param cards as the system numbers them
  explicit CardPool(std::vector<int> cards) : cards_(std::move(cards)), slices_(cards_.size(), 0) {}

  /// A card, for as long as this lives.
  class Lease {
   public:
    /// @pre the pool has cards, and outlives this
    explicit Lease(CardPool& pool) : pool_(pool) {
      const std::lock_guard<std::mutex> lock(pool_.mutex_);
      const auto least = std::min_element(pool_.slices_.begin(), pool_.slices_.end());
      place_ = static_cast<std::size_t>(least - pool_.slices_.begin());
      ++pool_.slices_[place_];
    }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    ~Lease() {
      const std::lock_guard<std::mutex> lock(pool_.mutex_);
      --pool_.slices_[place_];
    }
    int card() const { return pool_.cards_[place_]; }

   private:
    CardPool& pool_;
    std::size_t place_ = 0;
  };

 private:
  std::vector<int> cards_;
  std::vector<int> slices_;  ///< [cards] that have it now
  std::mutex mutex_;
};

}  // namespace weft
