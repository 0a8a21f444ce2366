// The board's end of the line to the chip: a UART, or a byte-wide port.
#pragma once

#include <cstdint>

#include "uart.hpp"

namespace board {

// The chip's outputs to the line after a cycle; a chip has `tx`, or the byte-wide port.
struct FromChip {
    bool tx = true;
    bool tx_valid = false;
    std::uint8_t tx_data = 0;
    bool rx_ready = false;
};

// Inputs of the chip during the next cycle. The board takes each byte of a byte-wide port at once.
struct ToChip {
    bool rst = false;
    bool rx = true;
    bool rx_valid = false;
    std::uint8_t rx_data = 0;
};

class Port {
public:
    // With 0 clocks per bit the port is byte-wide.
    explicit Port(unsigned clocks_per_bit)
        : is_uart_{clocks_per_bit != 0},
          quiet_cycles_{is_uart_ ? kQuietBits * clocks_per_bit : kQuietCycles},
          driver_{clocks_per_bit},
          sampler_{clocks_per_bit} {}

    void push(const std::uint8_t* bytes, std::size_t count) { driver_.push(bytes, count); }

    // Forgets the bytes that wait; the byte on the line is completed.
    void drop() { driver_.drop(); }

    std::size_t waiting() const { return driver_.waiting(); }
    std::uint64_t begun() const { return driver_.begun(); }
    bool idle() const { return is_uart_ ? driver_.idle() && sampler_.idle() : waiting() == 0; }

    // Cycles of silence after which the chip has answered all.
    std::uint64_t quiet_cycles() const { return quiet_cycles_; }

    // The byte of the last event.
    std::uint8_t byte() const { return byte_; }

    // Takes the outputs after a cycle.
    UartSampler::Event sample(const FromChip& pins) {
        if (is_uart_) {
            const auto event = sampler_.clock(pins.tx);
            byte_ = sampler_.byte();
            return event;
        }
        byte_ = pins.tx_data;
        return pins.tx_valid ? UartSampler::Event::kByte : UartSampler::Event::kNothing;
    }

    // Returns the inputs of the next cycle. The chip's `rx_ready` comes from registers, so that its
    // value after this cycle says whether the next one transfers a byte.
    ToChip drive(const FromChip& pins) {
        ToChip inputs;
        if (is_uart_) {
            inputs.rx = driver_.clock();
        } else if (pins.rx_ready && waiting() != 0) {
            inputs.rx_valid = true;
            inputs.rx_data = driver_.take();
        }
        return inputs;
    }

private:
    static constexpr unsigned kQuietBits = 640;
    static constexpr unsigned kQuietCycles = 4096;

    const bool is_uart_;
    const std::uint64_t quiet_cycles_;
    UartDriver driver_;
    UartSampler sampler_;
    std::uint8_t byte_ = 0;
};

}  // namespace board
