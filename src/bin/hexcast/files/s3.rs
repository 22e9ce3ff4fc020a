//! A store in a bucket of S3, or of a service with its interface. Endpoint and credentials come from the variables that AWS's own
//! programs read: `AWS_ENDPOINT_URL`, `AWS_ACCESS_KEY_ID`, `AWS_SECRET_ACCESS_KEY`, `AWS_SESSION_TOKEN`, `AWS_REGION` and others.
//!
//! Requests that fail, such as those to a server that restarts, are repeated for up to three minutes.

use futures_util::TryStreamExt;
use hexcast::{Error, Result};
use object_store::aws::{AmazonS3, AmazonS3Builder, AmazonS3ConfigKey};
use object_store::path::Path;
use object_store::{ObjectStore, ObjectStoreExt};
use tokio::runtime::Runtime;

use crate::files::store::Store;

/// Part of a bucket.
pub(crate) struct Bucket {
    client: AmazonS3,
    /// What every key begins with.
    prefix: String,
    /// `s3://BUCKET`, for messages.
    name: String,
    runtime: Runtime,
}

impl Bucket {
    /// Opens `s3://BUCKET/PREFIX`; no request is made yet.
    ///
    /// # Errors
    /// `io` where the name has no bucket, or the variables contradict each other.
    pub(crate) fn open(name: &str) -> Result<Bucket> {
        let wrong = |why: String, hint: &str| Error::new("io", format!("{name}: {why}"), hint);
        let (bucket, prefix) = name.trim_start_matches("s3://").split_once('/').unwrap_or_default();
        if bucket.is_empty() || prefix.is_empty() {
            return Err(wrong("it has no bucket or no name".into(), "name a store as in s3://bucket/mesh.zarr"));
        }
        // of two ciphers that would do, the one that is built without cmake; an error says that one is chosen already
        let _ = rustls::crypto::ring::default_provider().install_default();
        let builder = AmazonS3Builder::from_env().with_bucket_name(bucket);
        // whoever names an endpoint without TLS wants that
        let endpoint = builder.get_config_value(&AmazonS3ConfigKey::Endpoint);
        let is_plain = endpoint.is_some_and(|endpoint| endpoint.starts_with("http://"));
        let builder = if is_plain { builder.with_allow_http(true) } else { builder };
        let client = builder.build().map_err(|error| wrong(error.to_string(), VARIABLES))?;
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
        let runtime = runtime.map_err(|error| Error::io(format!("{name}: starting threads"), error))?;
        Ok(Bucket { client, prefix: prefix.trim_end_matches('/').into(), name: format!("s3://{bucket}"), runtime })
    }

    fn path(&self, key: &str) -> Path {
        Path::from(format!("{}/{key}", self.prefix))
    }

    fn failed(&self, doing: &str, key: &str, error: &object_store::Error) -> Error {
        Error::new("io", format!("{doing} {}/{}: {error}", self.name, self.path(key)), VARIABLES)
    }
}

const VARIABLES: &str = "make sure that the bucket is there, and that AWS_ENDPOINT_URL, AWS_REGION, AWS_ACCESS_KEY_ID and \
    AWS_SECRET_ACCESS_KEY say where it is and who you are";

impl Store for Bucket {
    fn get(&self, key: &str) -> Result<Option<Vec<u8>>> {
        let path = self.path(key);
        let found = self.runtime.block_on(async { self.client.get(&path).await?.bytes().await });
        match found {
            Ok(value) => Ok(Some(value.to_vec())),
            Err(object_store::Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(self.failed("reading", key, &error)),
        }
    }

    fn put(&self, key: &str, value: &[u8]) -> Result<()> {
        let path = self.path(key);
        let put = self.runtime.block_on(self.client.put(&path, value.to_vec().into()));
        put.map(|_| ()).map_err(|error| self.failed("writing", key, &error))
    }

    fn keys(&self, prefix: &str) -> Result<Vec<String>> {
        let path = self.path(prefix);
        let listed = self.runtime.block_on(self.client.list(Some(&path)).try_collect::<Vec<_>>());
        let listed = listed.map_err(|error| self.failed("listing", prefix, &error))?;
        let key = |path: &Path| path.as_ref().strip_prefix(&format!("{}/", self.prefix)).map(String::from);
        Ok(listed.iter().filter_map(|object| key(&object.location)).collect())
    }
}
