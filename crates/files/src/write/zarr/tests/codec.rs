//! The codec `gzip` of Zarr v3 for the crate `zarrs`, with the compressor of the other formats.
//!
//! The crate's own codec would switch the compressor of all tests to a C library, and with it the bytes of all compressed files.

use std::any::Any;
use std::borrow::Cow;
use std::io::Read;
use std::sync::{Arc, Once};

use flate2::read::GzDecoder;
use zarrs::array::{
    ArrayBytesRaw, BytesRepresentation, BytesToBytesCodecTraits, CodecError, CodecMetadataOptions, CodecOptions,
    CodecTraits, RecommendedConcurrency,
};
use zarrs::metadata::Configuration;
use zarrs::plugin::{ExtensionName, ZarrVersion};
use zarrs_codec::{Codec, CodecRuntimePluginV3, PartialDecoderCapability, PartialEncoderCapability, register_codec_v3};

use crate::write::store::gzip;

/// gzip at a level, 1 to 9.
#[derive(Debug, Clone, Copy)]
struct Gzip(u8);

/// Lets `zarrs` find the codec.
pub(super) fn register() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        register_codec_v3(CodecRuntimePluginV3::new(
            |name| name == "gzip",
            |metadata| {
                let level = metadata.configuration().and_then(|facts| facts.get("level")?.as_u64()).expect("a level");
                Ok(Codec::BytesToBytes(Arc::new(Gzip(level as u8))))
            },
        ));
    });
}

impl ExtensionName for Gzip {
    fn name(&self, _: ZarrVersion) -> Option<Cow<'static, str>> {
        Some("gzip".into())
    }
}

impl CodecTraits for Gzip {
    fn as_any(&self) -> &dyn Any {
        self
    }

    fn configuration(&self, _: ZarrVersion, _: &CodecMetadataOptions) -> Option<Configuration> {
        let mut configuration = serde_json::Map::new();
        configuration.insert("level".into(), self.0.into());
        Some(configuration.into())
    }

    fn partial_decoder_capability(&self) -> PartialDecoderCapability {
        PartialDecoderCapability { partial_read: false, partial_decode: false }
    }

    fn partial_encoder_capability(&self) -> PartialEncoderCapability {
        PartialEncoderCapability { partial_encode: false }
    }
}

impl BytesToBytesCodecTraits for Gzip {
    fn into_dyn(self: Arc<Self>) -> Arc<dyn BytesToBytesCodecTraits> {
        self
    }

    fn recommended_concurrency(&self, _: &BytesRepresentation) -> Result<RecommendedConcurrency, CodecError> {
        Ok(RecommendedConcurrency::new_maximum(1))
    }

    fn encoded_representation(&self, decoded: &BytesRepresentation) -> BytesRepresentation {
        // deflate's bound for any input, and 18 bytes of head and checksum
        let bound = |size: u64| size + size.div_ceil(8) + size.div_ceil(64) + 5 + 18;
        decoded.size().map_or(BytesRepresentation::UnboundedSize, |size| BytesRepresentation::BoundedSize(bound(size)))
    }

    fn encode<'a>(&self, decoded: ArrayBytesRaw<'a>, _: &CodecOptions) -> Result<ArrayBytesRaw<'a>, CodecError> {
        gzip(self.0, &decoded).map(Cow::Owned).map_err(|error| CodecError::Other(error.to_string()))
    }

    fn decode<'a>(
        &self,
        encoded: ArrayBytesRaw<'a>,
        decoded: &BytesRepresentation,
        _: &CodecOptions,
    ) -> Result<ArrayBytesRaw<'a>, CodecError> {
        let mut out = Vec::new();
        // no more than one byte too many, whatever the file says
        let most = decoded.size().map_or(u64::MAX, |size| size.saturating_add(1));
        GzDecoder::new(&*encoded).take(most).read_to_end(&mut out)?;
        Ok(Cow::Owned(out))
    }
}
