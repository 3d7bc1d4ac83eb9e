
static const unsigned char common[sizeof(struct beginning)] __attribute__((aligned(8))) = {$begins};
static const struct moved common_calls[] = {$calls};

/* What a run begins with: what is common, and words of its own one after the other. */
static inline __attribute__((always_inline)) void begin_as_common(struct beginning *beginning, const uint64_t *own)
{
    __builtin_memcpy(beginning, common, sizeof *beginning);
$places
}

/* The words of its own of what a run begins with; false where it differs from what is common elsewhere, too. */
static inline bool own_of(const struct beginning *beginning, uint64_t *own)
{
    struct beginning same;
$words
    begin_as_common(&same, own);
    return __builtin_memcmp(&same, beginning, sizeof same) == 0;
}

#define OWN $count
