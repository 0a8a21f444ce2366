// Drives the Verilated evaluator of paths. Orders come on standard input, answers go to standard
// output, all numbers 64-bit little-endian:
//
//   1 n word*n        writes n corners, one payload of `writes` each
//   2 n word*n        gives the problem, 32 bits in each number, and voids the memo
//   3 stall p (head gap points)*p  n word*n
//                     evaluates p paths: payload of each head, cycles to wait before its first
//                     point is offered, its number of points; then the payloads of all points. With
//                     a stall s above 0, points and keys move only in about one cycle of s.
//       answers: p * (payload of the key, cycles in which the first point was offered, the goal
//                taken, the key taken), the cycles of walking, the number of margins, p * (bits of
//                the decision, its cycle), and of each margin its bits and its cycle
//
// A slot of the scorer begins with an even cycle.

#include "../../sim/harness/harness.hpp"

namespace {

using namespace harness;

class Evaluator : Design {
public:
    Evaluator() { rest(); }

    void write(const Numbers& corners) {
        top_.writes___05Fvalid = 1;
        for (const auto corner : corners) {
            top_.writes___05Fpayload = corner;
            clock();
        }
        top_.writes___05Fvalid = 0;
        for (int i = 0; i < 4; ++i) clock();
    }

    void begin(const Numbers& words) {
        for (std::size_t i = 0; i < words.size(); ++i) top_.problem[i] = words[i];
        top_.clear = top_.clear_counters = 1;
        clock();
        top_.clear = top_.clear_counters = 0;
        rest();
    }

    void evaluate(Number stall, const Numbers& paths, const Numbers& points) {
        const std::size_t count = paths.size() / 3;
        Numbers keys, offers, goals, keyed, decided, margins;
        std::size_t head = 0, path = 0, point = 0;
        Number wait = paths[1] + 3, left = paths[2];
        Pauses pauses{stall};
        bool held = false;
        for (Number cycle = 0; keys.size() < count || !top_.idle; ++cycle) {
            if (cycle > limit_) give_up();
            pauses.draw();
            top_.phase = cycle & 1;
            top_.paths___05Fvalid = head < count;
            if (head < count) top_.paths___05Fpayload = paths[3 * head];
            // An offer stays until it is taken.
            const bool may = path < count && wait == 0 && (held || pauses.moves());
            top_.points___05Fvalid = may;
            if (may) {
                top_.points___05Fpayload = points[point];
                if (offers.size() == path) offers.push_back(cycle);
            }
            top_.evaluated___05Fready = pauses.moves(1);
            top_.eval();
            held = may && !top_.points___05Fready;
            if (wait > 0) --wait;
            if (may && top_.points___05Fready) {
                ++point;
                if (--left == 0) {
                    goals.push_back(cycle);
                    if (++path < count) wait = paths[3 * path + 1], left = paths[3 * path + 2];
                }
            }
            if (head < count && top_.paths___05Fready) ++head;
            if (top_.decided & 1) decided.insert(decided.end(), {top_.decided, cycle});
            if (top_.margin & 1) margins.insert(margins.end(), {top_.margin, cycle});
            if (top_.evaluated___05Fvalid && top_.evaluated___05Fready) {
                keys.push_back(top_.evaluated___05Fpayload);
                keyed.push_back(cycle);
            }
            clock();
        }
        if (point != points.size() || decided.size() != 2 * count) std::exit(5);
        for (std::size_t i = 0; i < count; ++i) {
            write_numbers({keys[i], offers[i], goals[i], keyed[i]});
        }
        write_numbers({top_.walk, margins.size() / 2});
        write_numbers(decided);
        write_numbers(margins);
    }

private:
    void rest() {
        clock_while([&] { return top_.busy; });
        for (int i = 0; i < 4; ++i) clock();
    }
};

}  // namespace

int main() {
    Evaluator evaluator;
    for (Number order; next_order(order);) {
        if (order == 1) {
            evaluator.write(read_numbers(read_number()));
        } else if (order == 2) {
            evaluator.begin(read_numbers(read_number()));
        } else if (order == 3) {
            const Number stall = read_number();
            const auto paths = read_numbers(3 * read_number());
            evaluator.evaluate(stall, paths, read_numbers(read_number()));
        } else {
            return 3;
        }
    }
    return 0;
}
