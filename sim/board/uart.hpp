// The two ends of an 8N1 line, advanced one cycle at a time.
#pragma once

#include <cstdint>
#include <deque>

namespace board {

// Sends bytes to the chip: the level of its `rx` pin in each cycle.
//
// Every bit lasts exactly `clocks_per_bit` cycles. The start bit of a waiting byte follows directly
// after the stop bit of the previous byte, as on a real line at full rate.
class UartDriver {
public:
    explicit UartDriver(unsigned clocks_per_bit) : clocks_per_bit_{clocks_per_bit} {}

    void push(const std::uint8_t* bytes, std::size_t count) {
        waiting_.insert(waiting_.end(), bytes, bytes + count);
    }

    // Forgets the bytes that wait; the byte on the line is completed.
    void drop() { waiting_.clear(); }

    std::size_t waiting() const { return waiting_.size(); }
    std::uint64_t begun() const { return begun_; }  // Bytes whose start bit has begun.
    bool idle() const { return frame_ == 0 && waiting_.empty(); }

    // Removes the first byte that waits; it counts as begun.
    std::uint8_t take() {
        const auto byte = waiting_.front();
        waiting_.pop_front();
        ++begun_;
        return byte;
    }

    // Level during the next cycle.
    bool clock() {
        if (cycles_left_ == 0) {
            frame_ >>= 1;
            if (frame_ <= kSentinel) {
                frame_ = 0;
                if (waiting_.empty()) return true;
                frame_ = kSentinel << 10 | 1u << 9 | unsigned{take()} << 1;
            }
            cycles_left_ = clocks_per_bit_;
        }
        --cycles_left_;
        return frame_ & 1;
    }

private:
    static constexpr unsigned kSentinel = 1;  // Follows the last bit; alone: all is sent.

    const unsigned clocks_per_bit_;
    unsigned cycles_left_ = 0;
    unsigned frame_ = 0;
    std::uint64_t begun_ = 0;
    std::deque<std::uint8_t> waiting_;
};

// Receives bytes from the chip's `tx` pin; samples each bit in its middle.
class UartSampler {
public:
    enum class Event { kNothing, kByte, kGlitch, kFramingError };

    explicit UartSampler(unsigned clocks_per_bit) : clocks_per_bit_{clocks_per_bit} {}

    std::uint8_t byte() const { return static_cast<std::uint8_t>(frame_ >> 1); }
    bool idle() const { return state_ == State::kIdle; }

    // Takes the level after a cycle.
    Event clock(bool level) {
        switch (state_) {
            case State::kIdle:
                if (!level) {
                    state_ = State::kFrame;
                    frame_ = 0;
                    bit_ = 0;
                    cycles_left_ = clocks_per_bit_ / 2;
                }
                return Event::kNothing;
            case State::kBreak:
                if (level) state_ = State::kIdle;
                return Event::kNothing;
            case State::kFrame:
                break;
        }
        if (--cycles_left_ != 0) return Event::kNothing;
        cycles_left_ = clocks_per_bit_;
        frame_ |= unsigned{level} << bit_;
        if (bit_ == 0 && level) {
            state_ = State::kIdle;
            return Event::kGlitch;
        }
        if (bit_++ < 9) return Event::kNothing;
        state_ = level ? State::kIdle : State::kBreak;
        return level ? Event::kByte : Event::kFramingError;
    }

private:
    enum class State { kIdle, kFrame, kBreak };

    const unsigned clocks_per_bit_;
    State state_ = State::kIdle;
    unsigned cycles_left_ = 0;
    unsigned frame_ = 0;
    unsigned bit_ = 0;
};

}  // namespace board
