static int64_t derive(void *block)
{
    return @BLOCK@__derive(block);
}

static int64_t derive_along(void *block, void *direction)
{
    return @DIFFERENTIATED@(block, direction);
}

static bool settle(void *block)
{
    return @BLOCK@__settle(block);
}

static void measure(void *block)
{
    @BLOCK@__measure(block);
}

static const uint32_t STATES[] = {@STATES@};
static const uint32_t RATES[] = {@RATES@};
static const double NOMINALS[] = {@NOMINALS@};
static const uint32_t INDICATORS[] = {@INDICATORS@};
static const uint32_t UNKNOWNS[] = {@UNKNOWNS@};

static const struct Continuous CONTINUOUS = {
    .states = STATES,
    .rates = RATES,
    .nominals = NOMINALS,
    .state_count = sizeof STATES / sizeof *STATES,
    .indicators = INDICATORS,
    .indicator_count = sizeof INDICATORS / sizeof *INDICATORS,
    .unknowns = UNKNOWNS,
    .unknown_count = sizeof UNKNOWNS / sizeof *UNKNOWNS,
    .derive = derive,
    .differentiate = derive_along,
    .settle = settle,
    .measure = measure,
};

